"""`rodwnl reproduce`: what stands in the folder is whole, true, and needs nothing from outside."""

import json
import os
import re
import signal
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from html.parser import HTMLParser

import pytest

from rodwnl import figures, tables
from rodwnl.cli import run
from rodwnl.errors import ComputationError
from rodwnl.figuredata import coexisting, orbits, paper_columns, simulated, starts
from rodwnl.tables import compared_rows
from rodwnl.workers import processes


class Links(HTMLParser):
    """Every address a page names, its ids, and its tags that were not closed."""

    def __init__(self, text):
        super().__init__()
        self.addresses, self.ids, self.open = [], set(), []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        values = dict(attributes)
        self.addresses += [values[name] for name in ("href", "src") if name in values]
        self.ids.add(values.get("id"))
        if tag not in ("meta", "img", "br", "input", "link"):
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag


@pytest.fixture(scope="module")
def drawn(tmp_path_factory):
    """Two figures as `draw_all` leaves them, drawn once."""
    from rodwnl import drawings
    from rodwnl.reduced import reduced_model

    folder = tmp_path_factory.mktemp("drawn")
    column = paper_columns()[0]
    path = figures.eigenvalue_path(column, 30, 45, 16)
    model = reduced_model(column.rod, repr(column.coefficients.force), column.coefficients)
    return [
        figures.write(one, folder) for one in (drawings.modes([model]), drawings.hopf([column, column], path))
    ]


@pytest.fixture
def sketched(drawn, monkeypatch):
    """The whole command with those figures instead of the long computation."""

    def draw_all(folder, watch, quick, workers, each):
        for one in drawn:
            for suffix in (".svg", ".png", ".csv", ".txt"):
                (folder / f"{one.name}{suffix}").write_bytes(one.path(suffix).read_bytes())
            each(replace(one, folder=folder))

    monkeypatch.setattr(figures, "draw_all", draw_all)


def test_the_folder_holds_a_page_whose_links_lead_to_its_files(sketched, tmp_path, capsys):
    folder = tmp_path / "new" / "made"
    assert run(["reproduce", "--out", str(folder)]) == 0
    out = capsys.readouterr().out
    assert "36 numeric, 4 erratum, 0 differs" in out
    assert re.search(r"equations: \d+ premise, \d+ verified, 0 differs", out)
    text = (folder / "index.html").read_text(encoding="utf-8")
    page = Links(text)
    assert page.open == []
    for address in page.addresses:
        name, _, anchor = address.partition("#")
        assert not re.match(r"\w+:|//", address)
        assert (folder / name).is_file() if name else anchor in page.ids
    named = {address for address in page.addresses if address.startswith("figures/")}
    assert named == {f"figures/{name}{s}" for name in ("hopf", "modes") for s in (".svg", ".png", ".csv")}
    assert text.index('id="hopf"') < text.index('id="modes"')
    assert "url(" not in text
    assert "did not finish" not in text
    assert not list(folder.rglob(".*"))


def test_the_page_and_the_document_hold_every_cell_and_count(sketched, tmp_path, capsys):
    assert run(["reproduce", "--json", "--quick", "--digits", "20", "--out", str(tmp_path)]) == 0
    document = json.loads(capsys.readouterr().out)
    assert json.loads((tmp_path / "reproduction.json").read_text(encoding="utf-8")) == document
    assert document["counts"] == {"numeric": 36, "erratum": 4, "differs": 0}
    text = (tmp_path / "index.html").read_text(encoding="utf-8")
    for row, cells in compared_rows():
        for part in (*row.cells.values(), *(cell.computed for cell in cells)):
            assert f">{part}<" in text or f"</small> {part}<" in text
    ledger = (tmp_path / "ledger.html").read_text(encoding="utf-8")
    assert ledger.count('<tr class="row') == sum(document["equations"]["counts"].values())
    for status, count in document["equations"]["counts"].items():
        assert re.search(rf'{count} <span class="[\w-]*">{status}</span>', text)
    assert document["exact"][0]["force"] in text
    assert document["left_out"] in text
    assert {"rodwnl", "Python", "numpy", "generated/follower"} <= set(document["made_from"])
    for figure in document["figures"]:
        assert figure["caption"].split(",")[0] in text
        assert all((tmp_path / file).is_file() for file in figure["files"])


def test_what_differs_is_shown_and_makes_the_exit_code_1(sketched, tmp_path, monkeypatch, capsys):
    changed = tables.errata()[1:]
    monkeypatch.setattr(tables, "errata", lambda: changed)
    compared_rows.cache_clear()
    try:
        assert run(["reproduce", "--out", str(tmp_path)]) == 1
    finally:
        compared_rows.cache_clear()
    assert "DIFFERS" in capsys.readouterr().out
    text = (tmp_path / "index.html").read_text(encoding="utf-8")
    assert '<span class="differs"><small>differs</small> -971.76 + 29.07i</span>' in text
    assert "not a reviewed erratum" in text


def test_an_equation_that_differs_does_too(sketched, tmp_path, monkeypatch, capsys):
    from rodwnl import verification

    report = verification.check(only="eq:clamping.2")
    first = report.findings[0]
    wrong = replace(first, row=replace(first.row, status="differs", reason="x < y"))
    monkeypatch.setattr(verification, "check", lambda: replace(report, findings=(wrong,)))
    assert run(["reproduce", "--out", str(tmp_path)]) == 1
    assert f"{first.label} differs: x < y" in capsys.readouterr().out
    text = (tmp_path / "index.html").read_text(encoding="utf-8")
    assert f'<a href="ledger.html#{first.label}">' in text
    assert "x &lt; y" in text


def test_what_was_finished_stays_when_a_figure_fails(drawn, tmp_path, monkeypatch, capsys):
    def draw_all(folder, watch, quick, workers, each):
        each(drawn[0])
        raise KeyboardInterrupt

    monkeypatch.setattr(figures, "draw_all", draw_all)
    assert run(["reproduce", "--out", str(tmp_path)]) == 130
    text = (tmp_path / "index.html").read_text(encoding="utf-8")
    assert "did not finish" in text
    assert 'id="modes"' in text
    assert sorted(path.name for path in tmp_path.iterdir()) == ["figures", "index.html", "ledger.html"]


def test_a_folder_that_cannot_be_written_is_refused_before_the_work(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(tables, "compared_rows", lambda: pytest.fail("work was done"))
    file = tmp_path / "file"
    file.write_text("")
    taken = tmp_path / "taken"
    (taken / "index.html").mkdir(parents=True)
    for folder in (file, file / "below", taken):
        assert run(["reproduce", "--out", str(folder)]) == 2
        out, err = capsys.readouterr()
        assert (out, err.count("\n")) == ("", 1)
        assert str(tmp_path) in err


def test_tables_alone_write_nothing(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert run(["reproduce", "--tables"]) == 0
    assert "0 differs" in capsys.readouterr().out
    assert list(tmp_path.iterdir()) == []
    assert run(["reproduce", "--tables", "--out", "x"]) == 2
    assert "leave --out and --quick away" in capsys.readouterr().err


def test_a_quick_comparison_leaves_out_points_and_changes_none():
    lower, upper = paper_columns()[2:]
    for column in (lower, upper):
        whole, quick = starts(column), starts(column, quick=True)
        assert set(quick) < set(whole)
        assert all((force - column.coefficients.force) * column.side > 0 for force, _ in whole)


def test_both_states_are_simulated_between_threshold_and_fold():
    upper = paper_columns()[3]
    path, folds = orbits(upper)
    ((_, small), (force, large)) = coexisting(upper, folds)
    assert upper.coefficients.force < force < folds[0, 0] == path[:, 0].max()
    assert simulated(upper, force, small).reading.state == "decayed"
    settled = simulated(upper, force, large).reading
    assert settled.state == "settled"
    assert settled.A_tip > folds[0, 1]


def test_figures_are_computed_once_each_and_reported(monkeypatch):
    """In threads instead of processes, with the long parts replaced by their arguments."""
    calls, told = [], []
    columns = paper_columns()
    for name in ("eigenvalue_path", "orbits", "beating", "simulated"):
        monkeypatch.setattr(figures, name, lambda *given, name=name: calls.append((name, *given)) or ([], []))
    for name in ("hopf", "nonlinear", "compared", "beta_check", "modes"):
        monkeypatch.setattr(figures.drawings, name, lambda *given, name=name: (name, *given))
    monkeypatch.setattr(figures, "coexisting", lambda column, folds: [(0.0, 0.1), (0.0, 0.2)])
    with ThreadPoolExecutor(2) as pool:
        found = list(figures.computed(pool, lambda *news: told.append(news)))
    assert [name for name, *_ in found] == ["hopf", "beta_check", "modes", "nonlinear", "compared"]
    (comparisons,) = found[-1][1:]
    assert [item.column for item in comparisons] == list(columns)
    assert [len(item.points) for item in comparisons] == [len(starts(c)) + 2 for c in columns]
    assert sum(name == "orbits" for name, *_ in calls) == len(columns)
    assert max(done for _, done, _ in told) == len(calls) == told[-1][2]


def test_a_worker_that_is_killed_is_reported_and_says_nothing_itself(capfd):
    def interrupt_a_worker():
        with processes(1) as pool:
            os.kill(pool.submit(os.getpid).result(), signal.SIGINT)
            for _ in range(1000):
                pool.submit(time.sleep, 0.01).result()

    with pytest.raises(ComputationError, match="killed"):
        interrupt_a_worker()
    assert capfd.readouterr().err == ""


def test_an_interrupted_run_ends_at_once_and_leaves_no_half_file(tmp_path):
    folder = tmp_path / "made"
    command = [sys.executable, "-m", "rodwnl", "reproduce", "--quick", "--out", str(folder)]
    process = subprocess.Popen(
        command, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, start_new_session=True
    )
    try:
        deadline = time.monotonic() + 120
        while not (folder / "figures" / "hopf.svg").exists() and time.monotonic() < deadline:
            time.sleep(0.1)
        os.killpg(process.pid, signal.SIGINT)  # as a terminal does: every process of the command
        _, errors = process.communicate(timeout=60)
    finally:
        process.kill()
    assert process.returncode == 130
    assert b"Traceback" not in errors
    assert not list(folder.rglob(".*"))
    assert "did not finish" in (folder / "index.html").read_text(encoding="utf-8")
