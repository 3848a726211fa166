"""What the page over all results shows."""

# Section, title, file, caption: each is on the page where it has been made.
ON_THE_PAGE = [
    ("Claims", "Claims", "results/claims.md", "claims"),
    ("Claims", "Table I", "results/table_1.md", "table_1"),
    *[("Figures", f"Figure {n}", f"results/figures/figure_{n}.png", f"figure_{n}") for n in (2, 3, 4, 5)],
    ("Hidden effects", "The study", f"{HIDDEN_FOLDER}/summary.md", "hidden_effects"),
    ("Hidden effects", "The study", f"{HIDDEN_FOLDER}/figures", "hidden_effects"),
    ("Hidden effects", "The flight with each model", "results/closed_loop/summary.md", "closed_loop"),
    ("Hidden effects", "From the flight to the name, and back", "results/figures/story.png", "closed_loop"),
    ("Hidden effects", "Points that a Gaussian process needs", "results/figures/points_needed.png", "closed_loop"),
    ("Real flights", "Known and answered", "results/real_table/table.md", "real_table"),
    ("Real flights", "What changed", "results/what_changed/table.md", "what_changed"),
    ("Real flights", "What changed", "results/what_changed/confusion.png", "what_changed"),
    ("Real flights", "A pool of recorded flights", "results/figures/figure_pool.png", "pool"),
]


def entries_there(_):
    """What is there of these, as the page wants it."""
    return [
        {"section": section, "title": title, "path": path, "caption": f"workflow/report/{caption}.rst"}
        for section, title, path, caption in ON_THE_PAGE
        if Path(path).exists()
    ]


def recordings_there(_):
    """The recordings of all runs that are there."""
    return sorted(map(str, Path("results/recordings").rglob("*.rrd")))
