"""The page on the plants says of their air what the code computes."""

from pathlib import Path

import plant_numbers

PAGE = " ".join(Path("docs/plants.md").read_text().split())


def test_the_page_says_what_is_left_without_interference():
    assert f"what is left after the affine fit is {plant_numbers.without_interference()}" in PAGE


def test_the_page_says_what_a_rotor_of_blades_does():
    for said in plant_numbers.rotor_of_blades():
        assert said in PAGE
