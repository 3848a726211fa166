"""The cases of the table of real flights, and which of them can be made here."""

from infotraj.experiment.real.cases import missing, read_cases

REAL_CASE = "results/real_table/{case}"


def real_cases():
    """The cases that the configuration asks for, by name."""
    cases = checked(read_cases, CONFIG.real_table.cases)
    return {case.name: case for case in checked(cases.chosen, CONFIG.real_table.only)}


def real_case_logs(wildcards):
    """Name and size of a case's logs, and how they are cut: others rerun what reads them."""
    case = real_cases()[wildcards.case]
    folder = location.find_dataset(case.folder, CONFIG.data_dir)
    files = [window.file.split("#")[0] for window in (*case.fit, *case.held)]
    sizes = folder and [(name, (folder / name).stat().st_size) for name in files]
    return [case.mapping, case.accept, sizes, [w.model_dump() for w in (*case.fit, *case.held)]]


def real_case_asked(wildcards):
    """What a case asks, without what is known of its answer: a better description reruns nothing."""
    asked = {"model", "fit", "held", "force_from"}
    return real_cases()[wildcards.case].model_dump(mode="json", include=asked)


def real_answers(_):
    """The answers of the cases whose data are here; the others are named on standard error."""
    answers = []
    for name, case in real_cases().items():
        if why := missing(case, CONFIG.data_dir):
            print(f"Skipped: {name}: {why}", file=sys.stderr)
        else:
            answers.append(f"{REAL_CASE.format(case=name)}/answer.json")
    return answers
