"""Records that the libraries of their formats write."""

import numpy as np

# Of pressure and wheel: a pressure [bar] over the crank angle is written as one over time, too.
RATE = 50000.0


def tdms(path, channels):
    """Write channels, a mapping of (group, name) to values and properties."""
    from nptdms import ChannelObject, TdmsWriter

    with TdmsWriter(path) as writer:
        writer.write_segment(
            [
                ChannelObject(group, name, np.asarray(values), properties=facts)
                for (group, name), (values, facts) in channels.items()
            ]
        )
    return path


def mdf(path, *groups):
    """Write groups: signals (name, unit, values), places, name of the master, and its type."""
    from asammdf import MDF, Signal

    with MDF(version="4.10") as file:
        for signals, places, master, label in groups:
            file.append(
                [
                    Signal(
                        np.asarray(values),
                        np.asarray(places),
                        name=name,
                        unit=unit,
                        master_metadata=master,
                    )
                    for name, unit, values in signals
                ],
                acq_name=label,
            )
        file.save(path, overwrite=True)
    return path


def uff(path, *functions, force_double=True):
    """Write functions of time: name, unit, instants, values, and more."""
    import pyuff

    for name, unit, instants, values, more in functions:
        record = {
            "type": 58, "binary": 0, "func_type": 1, "rsp_node": 1, "rsp_dir": 1, "ref_node": 1,
            "ref_dir": 1, "orddenom_spec_data_type": 0, "abscissa_spec_data_type": 17,
            "abscissa_spacing": 1, "id1": name, "ordinate_axis_units_lab": unit,
            "x": np.asarray(instants), "data": np.asarray(values, dtype=float),
        }  # fmt: skip
        pyuff.UFF(str(path)).write_sets(record | more, force_double=force_double)
    return path


def hdf5(path, tree, **attributes):
    """Write nested data sets: values, or values and their attributes."""
    import h5py

    def add(group, parts):
        for name, value in parts.items():
            if isinstance(value, dict):
                add(group.create_group(name), value)
                continue
            values, facts = value if isinstance(value, tuple) else (value, {})
            group.create_dataset(name, data=values).attrs.update(facts)

    with h5py.File(path, "w") as file:
        file.attrs.update(attributes)
        add(file, tree)
    return path


def mat73(path, tree):
    """Write variables as Matlab 7.3 does: turned over, texts as numbers, cells as references."""
    import h5py

    def add(group, name, value, file):
        if isinstance(value, dict):
            part = group.create_group(name)
            part.attrs["MATLAB_class"] = np.bytes_("struct")
            for inner, content in value.items():
                add(part, inner, content, file)
        elif isinstance(value, str):
            letters = np.array([[ord(letter)] for letter in value], dtype=np.uint16)
            group.create_dataset(name, data=letters).attrs["MATLAB_class"] = np.bytes_("char")
        elif isinstance(value, list):
            references = []
            hidden = file.require_group("#refs#")
            for content in value:
                place = f"c{len(hidden)}"
                add(hidden, place, content, file)
                references.append(hidden[place].ref)
            made = group.create_dataset(
                name, data=np.array([[each] for each in references], dtype=h5py.ref_dtype)
            )
            made.attrs["MATLAB_class"] = np.bytes_("cell")
        else:
            turned = (
                np.atleast_2d(np.asarray(value, dtype=float)).reshape(-1, 1)
                if np.ndim(value) < 2
                else value
            )
            made = group.create_dataset(name, data=np.asarray(turned).T)
            made.attrs["MATLAB_class"] = np.bytes_("double")

    with h5py.File(path, "w", userblock_size=512) as file:
        for name, value in tree.items():
            add(file, name, value, file)
    with open(path, "r+b") as file:
        file.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + b"\x00\x02IM")
    return path


def parquet(path, columns, units=None, **how):
    """Write columns; `units` are in the metadata of each."""
    import pyarrow as pa
    from pyarrow import parquet as files

    fields = [
        pa.field(
            name, pa.array(values).type, metadata={b"unit": (units or {}).get(name, "").encode()}
        )
        for name, values in columns.items()
    ]
    table = pa.table([pa.array(values) for values in columns.values()], schema=pa.schema(fields))
    files.write_table(table, path, **how)
    return path
