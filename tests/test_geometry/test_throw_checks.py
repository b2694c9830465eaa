"""Throws that are checked without laying out their parts."""

import random

from crankbase.errors import InputError
from geometry.throw import throw_parts
from geometry.throw_checks import FIRST_EIGHT, check_throw, fits_plainly
from geometry.throw_dimensions import ThrowDimensions


def test_a_throw_that_fits_plainly_passes_all_checks():
    seeded = random.Random(5)
    counts = {True: 0, False: 0}
    for _ in range(2000):
        journal, pin = 0.2, 0.2 * seeded.uniform(0.5, 1.2)
        larger = max(journal, pin)
        # Each dimension near the limit that it meets first, on either side.
        width = larger * seeded.choice([1.0, 1.005, 1.012, 1.1, 1.6])
        shortest = larger / 25.0 * seeded.choice([0.99, 1.0, 1.02, 3.0, 9.0])
        room = 0.5 * (width - larger)
        throw = ThrowDimensions(
            crank_radius=larger * seeded.choice([0.3, 0.6, 1.0, 2.5]),
            main_journal_diameter=journal,
            pin_diameter=pin,
            main_journal_length=max(shortest * seeded.uniform(0.9, 3.0), 0.005),
            pin_length=max(shortest * seeded.uniform(0.9, 3.0), 0.005),
            web_width=width,
            web_thickness=max(shortest * seeded.uniform(0.9, 2.0), 0.005),
            fillet_radius=seeded.choice([0.0, 0.009 * larger, 0.011 * larger, 0.9 * room, room]),
        )
        assert throw.model_fields_set == FIRST_EIGHT
        try:
            check_throw(throw, throw_parts(throw))
        except InputError:
            assert not fits_plainly(throw)
        else:
            counts[fits_plainly(throw)] += 1
    assert counts[True] > 200


def test_other_dimensions_are_left_to_the_whole_check():
    values = dict.fromkeys(FIRST_EIGHT, 0.1) | {"web_width": 0.15, "fillet_radius": 0.01}
    assert fits_plainly(ThrowDimensions(**values))
    assert not fits_plainly(ThrowDimensions(**values, pin_bore_offset=0.02))
