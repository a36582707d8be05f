"""A sample of random rods over many decades of every parameter; `make fuzz` runs ten thousand."""

import json
import subprocess
import sys
from dataclasses import replace

import pytest

from rodwnl import agreement
from rodwnl.agreement import RANGES, check, differences, random_rod
from rodwnl.coefficients import landau
from rodwnl.exact import exact_threshold

SAMPLE, CHUNK = 200, 10


@pytest.mark.parametrize("start", range(0, SAMPLE, CHUNK))
def test_float64_is_right_within_its_errors_or_refuses(start):
    for index in range(start, start + CHUNK):
        verdict = check(index)
        assert verdict.status in ("agrees", "stable"), verdict


def test_rods_are_reproducible_and_fill_the_ranges():
    rods = [random_rod(i) for i in range(300)]
    assert rods[7] == random_rod(7)
    assert rods[7] != random_rod(7, seed=1)
    for name, (low, high) in RANGES.items():
        values = [float(getattr(rod, name)) for rod in rods]
        assert float(low) <= min(values) < 2 * float(low) * (float(high) / float(low)) ** 0.05
        assert float(high) >= max(values) > float(high) / 2 / (float(high) / float(low)) ** 0.05


def test_a_wrong_number_is_seen():
    rod = random_rod(0)
    c = landau(rod, escalate=False)[0]
    exact = exact_threshold(rod, c.force, c.omega, 20)
    assert max(d.ratio for d in differences(c, exact)) <= 1
    wrong = replace(c, alpha=c.alpha * (1 + 1e-8))
    assert [d.name for d in differences(wrong, exact) if d.ratio > 1] == ["alpha"]


def test_a_run_goes_on_where_it_was_cut_off(tmp_path, monkeypatch, capsys):
    def run(*arguments):
        monkeypatch.setattr(sys, "argv", ["agreement", "--out", str(tmp_path), *arguments])
        code = agreement.main()
        return code, capsys.readouterr().out

    assert run("--count", "3", "--shard", "1/2")[1].startswith("2 rods: ")
    (file,) = tmp_path.glob("*.jsonl")
    file.write_text(file.read_text() + '{"index": 1, "rod"')
    computed = []
    monkeypatch.setattr(agreement, "check", lambda i, seed: computed.append(i) or check(i, seed))
    code, text = run("--count", "4")
    assert computed == [1, 3]
    assert code == 0
    assert text.startswith("4 rods: ")
    assert "0 wrong" in text
    file.write_text(file.read_text() + '{"index": 4, "rod"')
    assert run("--count", "6", "--shard", "1/2")[1].startswith("5 rods: ")
    assert run("--count", "6", "--shard", "1/2")[1].startswith("5 rods: ")
    assert computed == [1, 3, 4]


def test_a_wrong_rod_makes_the_run_fail(tmp_path):
    verdict = {"index": 0, "rod": {}, "status": "wrong", "detail": "alpha at force 1.0"}
    (tmp_path / "seed0-1-of-1.jsonl").write_text(json.dumps(verdict) + "\n")
    command = [sys.executable, "-m", "rodwnl.agreement", "--count", "0", "--out", str(tmp_path)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert "alpha at force 1.0" in done.stdout
