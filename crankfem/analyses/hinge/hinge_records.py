"""Results of an elastic hinge as plain JSON content, and as a table over the revolution."""

import numpy as np

from crankbase.checks.arrays import ComplexArray, FloatArray
from crankbase.units.units import RPM
from crankfem.analyses.hinge.hinge_run import HingeRun, OtherSpeed
from crankfem.analyses.record import Record, assumed_values, attributes
from dynamics.hinge.moment import HingeMoment
from dynamics.hinge.profile import HingeProfile
from dynamics.turning.speed_over_angle import SpeedOverAngle


def hinge_record(run: HingeRun) -> Record:
    """Return the results as plain numbers in SI units, angles in degrees, speeds in 1/min."""
    spring = run.profile.spring
    return {
        "engine": run.file.name,
        "speed_rpm": run.point.speed * RPM,
        "kinematics": run.moment.kinematics,
        "hinge_moment": _moment_record(run.moment),
        "kinematics_deviation": {str(name): share for name, share in run.deviations.items()},
        "spring": {
            **attributes(spring, "piston_area", "height", "pressure", "exponent"),
            "ambient_pressure": spring.ambient,
        },
        "profile": profile_record(run.profile)
        | {"roller_radius": run.profile.roller_radius, "surface": _surface_record(run.surface)},
        "turning": {
            "with_hinge": _turning_record(run.with_hinge),
            "without": _turning_record(run.without)
            | {"comes_round_at_mean_speed": run.refused is None, "reason": run.refused},
            "flywheel": {
                "inertia": run.flywheel,
                "mean_speed_rpm": run.flywheel_turn.mean_speed * RPM,
                "fluctuation": run.flywheel_turn.fluctuation,
            },
            "remaining_share": run.with_hinge.fluctuation / run.without.fluctuation,
        },
        "other_speeds": [_other_record(other) for other in run.others],
        "compared": [
            {**attributes(other, "height", "pressure"), "start_radius": radius}
            | ({"refused": made} if isinstance(made, str) else profile_record(made))
            for other, radius, made in run.compared
        ],
        "assumed": assumed_values(run.file.records),
    }


def profile_record(profile: HingeProfile) -> Record:
    """Return the properties of guides."""
    return {
        "smallest_radius": float(profile.radius.min()),
        "largest_radius": float(profile.radius.max()),
        "largest_compression": float(profile.compression.max()),
        "least_compression": float(profile.compression.min()),
        "largest_pressure": float(profile.pressure.max()),
        "lowest_pressure": float(profile.pressure.min()),
        "largest_spring_force": float(profile.spring_force.max()),
        "largest_normal_force": float(profile.normal_force.max()),
        "largest_force_angle_deg": float(np.abs(profile.force_angle_deg).max()),
        "checks": [
            {**attributes(check, "name", "met", "value", "limit", "unit"), "meaning": check.reason}
            for check in profile.checks
        ],
        "remarks": list(profile.remarks),
    }


def _surface_record(surface: ComplexArray | None) -> Record | None:
    """Least and largest distance of the guides' surface from the axis."""
    if surface is None:
        return None
    distance = np.abs(surface)
    return {"smallest_radius": float(distance.min()), "largest_radius": float(distance.max())}


def _moment_record(moment: HingeMoment) -> Record:
    degrees = moment.angles_deg
    highest, lowest = int(np.argmax(moment.moment)), int(np.argmin(moment.moment))
    return {
        "load": moment.load,
        "largest": float(moment.moment[highest]),
        "largest_at_deg": float(degrees[highest]),
        "least": float(moment.moment[lowest]),
        "least_at_deg": float(degrees[lowest]),
        "closing_error": moment.closing_error,
        "energy_swing": float(np.ptp(moment.stored_energy)),
        "largest_gas_force": float(moment.gas.max()),
        "reduced_inertia": [
            float(moment.reduced.inertia.min()),
            float(moment.reduced.inertia.max()),
        ],
    }


def _turning_record(turn: SpeedOverAngle) -> Record:
    return {
        "fluctuation": turn.fluctuation,
        "mean_speed_rpm": turn.mean_speed * RPM,
        "lowest_speed_rpm": float(turn.speed.min()) * RPM,
        "highest_speed_rpm": float(turn.speed.max()) * RPM,
    }


def _other_record(other: OtherSpeed) -> Record:
    best = other.best
    return {
        "speed_rpm": other.point.speed * RPM,
        "hinge_moment": _moment_record(other.point),
        **attributes(best, "fitted_ratio", "fluctuation", "moment_residual", "largest_residual"),
        "best_pressure": best.pressure,
        "best_ratio": best.ratio,
        "fluctuation_unchanged": best.unchanged,
        "flywheel_without_hinge": other.flywheel,
        "flywheel_with_hinge": other.flywheel_with_hinge,
    }


def hinge_columns(run: HingeRun) -> dict[str, FloatArray]:
    """Return forces, moments, guides and speeds over the revolution, by name with unit."""
    moment, profile = run.moment, run.profile
    surface = run.surface
    guides = {} if surface is None else {"guide_x_m": surface.real, "guide_y_m": surface.imag}
    return {
        "crank_angle_deg": moment.angles_deg,
        "gas_force_N": moment.gas,
        "reduced_inertia_kg_m2": moment.reduced.inertia,
        "inertia_rate_kg_m2_per_rad": moment.reduced.inertia_rate,
        "hinge_moment_N_m": moment.moment,
        "radius_m": profile.radius,
        "slope_m_per_rad": profile.slope,
        "curvature_per_m": profile.curvature,
        "compression_m": profile.compression,
        "pressure_Pa": profile.pressure,
        "spring_force_N": profile.spring_force,
        "normal_force_N": profile.normal_force,
        **guides,
        "speed_with_hinge_rad_per_s": _at(run.with_hinge, np.radians(moment.angles_deg)),
        "speed_without_rad_per_s": _at(run.without, np.radians(moment.angles_deg)),
    }


def _at(turn: SpeedOverAngle, angles: FloatArray) -> FloatArray:
    """Return the speed at angles, by linear interpolation between the steps of the integration."""
    return np.interp(angles, np.radians(turn.angle_deg), turn.speed)
