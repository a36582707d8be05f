import json
import re
import signal
import socket
import subprocess
import sys
from contextlib import contextmanager
from http.client import HTTPConnection
from threading import Thread
from time import sleep

import pytest

from rodwnl import RodParameters, cli, landau, predict
from rodwnl.errors import ComputationError, InputError
from rodwnl.explore import state as states
from rodwnl.explore.server import HOST, serve

from .browser import CHROMIUM, Browser

PAPER = {"k1": "200", "k2": "1e4", "gamma3": "1e-4", "gamma1": "0.5"}


@contextmanager
def served(**model):
    """The port of a running server."""
    with serve(**model) as server:
        thread = Thread(target=server.serve_forever)
        thread.start()
        try:
            yield server.server_address[1]
        finally:
            server.shutdown()
            thread.join()


@pytest.fixture
def port():
    with served() as number:
        yield number


def get(port, path, host=None):
    connection = HTTPConnection(HOST, port, timeout=60)
    connection.request("GET", path, headers={"Host": host or f"{HOST}:{port}"})
    answer = connection.getresponse()
    body = answer.read()
    connection.close()
    return answer, body


def question(port, path, **given):
    answer, body = get(port, f"{path}?" + "&".join(f"{name}={value}" for name, value in given.items()))
    return answer.status, json.loads(body)


def test_questions_are_answered_one_at_a_time(port, monkeypatch):
    """The working precision of mpmath is one for all threads."""
    running, most = [], []

    def slow(*_):
        running.append(1)
        most.append(len(running))
        sleep(0.02)
        running.pop()
        return {}

    monkeypatch.setattr("rodwnl.explore.server.state", slow)
    threads = [Thread(target=question, args=(port, "/state"), kwargs=PAPER) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert most == [1, 1, 1, 1]


def test_state_agrees_with_the_commands():
    rod = RodParameters(**PAPER)
    shown = states.state(rod, 60)
    assert len(shown["thresholds"]) == 2
    for found, t, p, prediction in zip(
        landau(rod), shown["thresholds"], shown["predictions"], predict(rod, 60), strict=True
    ):
        assert t["force"] == pytest.approx(found.force, rel=1e-9)
        assert complex(*t["alpha"]) == pytest.approx(found.alpha, rel=1e-9)
        assert complex(*t["beta"]) == pytest.approx(found.beta, rel=1e-9)
        assert (t["criticality"], t["crossing"]) == (found.criticality, found.crossing)
        assert p["exists"] == prediction.exists
        if p["exists"]:
            assert (p["A_tip"], p["omega"]) == pytest.approx((prediction.A_tip, prediction.omega), rel=1e-9)
            assert p["stable"] == prediction.stable
        assert t["mode"]["Y"][0] == [0, 0]
        assert t["mode"]["Y"][-1] == [1, 0]
        assert len(t["mode"]["Y"]) == len(t["mode"]["u"])


def test_spectrum_crosses_zero_at_the_thresholds():
    shown = states.state(RodParameters(**PAPER), 60)
    force, growth = shown["spectrum"]["force"], shown["spectrum"]["growth"]
    leading = [max(row) for row in growth]
    for f, g in zip(force, leading, strict=True):
        assert (g > 0) == (shown["thresholds"][0]["force"] < f < shown["thresholds"][1]["force"])
    at = max(z[0] for z in shown["eigenvalues"])
    assert at == pytest.approx(6.59 * (60 - 49.758), rel=0.3)  # Re β (F − F_c)


def test_orbits_start_at_the_threshold(monkeypatch):
    monkeypatch.setattr(states, "ORBITS", 5)
    found = states.orbits(RodParameters("1e4", "1e4", "1e-4"), 0)
    force, amplitude, stable = found["points"][-1]
    assert force > 37.66
    assert amplitude > 0.05
    assert stable
    with pytest.raises(ComputationError, match="there is no threshold 3: the rod has 1"):
        states.orbits(RodParameters("1e4", "1e4", "1e-4"), 2)


def test_a_rod_without_flutter():
    shown = states.state(RodParameters("50", "1e4", "1e-4"), 10)
    assert (shown["thresholds"], shown["status"], shown["searched"]) == ([], "none", 50)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"k1": "-3"}, "k1 is '-3', but it must be greater than zero"),
        ({"k1": "x"}, "not a finite number"),
        ({"force": "200"}, "only for 0 <= force < k1 = 200"),
        ({"threshold": "0.5"}, "must be a whole number"),
    ],
)
def test_bad_questions_are_answered(port, change, message):
    path = "/orbits" if "threshold" in change else "/state"
    status, document = question(port, path, **({"force": "60"} | PAPER | change))
    assert status == 400
    assert message in document["error"]


def test_missing_parameters_and_unknown_pages(port):
    status, document = question(port, "/state", k1="3")
    assert (status, document["error"]) == (400, "the rod also needs k2, gamma3, gamma1")
    status, document = question(port, "/etc/passwd")
    assert status == 404
    status, document = question(port, "/../server.py")
    assert status == 404


def test_only_this_machine(port):
    answer, _ = get(port, "/", host="evil.example")
    assert answer.status == 403
    answer, body = get(port, "/")
    assert answer.status == 200
    assert "default-src 'self'" in answer.headers["Content-Security-Policy"]
    assert b"http" not in body.replace(b"http-equiv", b"")  # nothing is fetched from elsewhere
    others = {a[4][0] for a in socket.getaddrinfo(socket.gethostname(), None, socket.AF_INET)} - {HOST}
    for address in others - {"127.0.1.1"}:
        with pytest.raises(ConnectionRefusedError):
            socket.create_connection((address, port), timeout=5)


def test_a_port_that_is_taken(port, capsys):
    with pytest.raises(InputError, match=f"cannot listen on {HOST}:{port}"):
        serve(port)
    assert cli.run(["explore", "--port", str(port), "--no-browser"]) == 2
    assert "give another --port" in capsys.readouterr().err
    assert cli.run(["explore", "--port", "70000"]) == 2
    assert "between 0 and 65535" in capsys.readouterr().err


def test_command_says_where_it_listens():
    command = [sys.executable, "-m", "rodwnl", "explore", "--no-browser"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        line = process.stdout.readline()
        assert line.startswith("http://127.0.0.1:")
        process.send_signal(signal.SIGINT)
        assert process.wait(30) == 130


def test_the_state_of_another_rod_agrees_with_the_commands():
    rod = RodParameters(200, "1e4", "1e-4", model="quartic", bend4="1/20")
    shown = states.state(rod, 60)
    for c, t, p, prediction in zip(
        landau(rod), shown["thresholds"], shown["predictions"], predict(rod, 60), strict=True
    ):
        assert (t["force"], t["omega"], complex(*t["alpha"])) == (c.force, c.omega, c.alpha)
        assert (t["criticality"], t["crossing"]) == (c.criticality, c.crossing)
        assert p["exists"] == prediction.exists
        if p["exists"]:
            assert (p["A_tip"], p["omega"]) == pytest.approx((prediction.A_tip, prediction.omega), rel=1e-12)
        assert t["mode"]["Y"][-1] == [1, 0]
        assert complex(*t["mode"]["Y"][-2]) == pytest.approx(1, abs=0.1)
    low, high = (t["force"] for t in shown["thresholds"])
    for f, growth in zip(shown["spectrum"]["force"], shown["spectrum"]["growth"], strict=True):
        assert (max(growth) > 0) == (low < f < high)
    assert states.state(RodParameters(200, "1e4", "1e-4", model="partial_follower", chi=0), 1)["buckling"]


def test_the_server_answers_for_its_rod():
    with served(model="quartic", own=(("stretch4", 100), ("bend4", 0))) as port:
        status, about = question(port, "/about")
        assert about["title"].startswith("Rod 'quartic': Planar Cosserat rod")
        assert about["parameters"] == [
            {"name": "stretch4", "start": 100.0, "low": 0.0, "high": 200.0},
            {"name": "bend4", "start": 0.0, "low": 0.0, "high": 1.0},
        ]
        status, document = question(port, "/state", **PAPER, force=60, bend4="1/20")
        assert status == 200
        rod = RodParameters(**PAPER, model="quartic", bend4="1/20")
        assert document["thresholds"][0]["force"] == landau(rod)[0].force
        status, document = question(port, "/state", **PAPER, force=310)
        assert status == 400
        assert "no straight state at force = 310" in document["error"]


def test_orbits_are_given_up_when_the_page_asks_for_something_else(port):
    answers = []
    stale = Thread(
        target=lambda: answers.append(question(port, "/orbits", **PAPER, threshold=0, page="a", question=1))
    )
    stale.start()
    assert question(port, "/state", **PAPER, force=60, page="a", question=2)[0] == 200
    stale.join()
    ((status, document),) = answers
    assert (status, document["error"]) == (400, "the page has asked for something else since")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--model", "nosuch"], "there is no rod 'nosuch'"),
        (["--model", "quartic", "--parameter", "chi=1"], "has no parameter 'chi'; its own are stretch4"),
        (["--parameter", "chi=1"], "name that one with --model"),
        (["--model", "quartic", "--parameter", "bend4=x"], "bend4 is 'x': not a finite number"),
    ],
)
def test_bad_rods_end_with_one_line(capsys, arguments, message):
    assert cli.run(["explore", "--no-browser", *arguments]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert re.search(message, line)


@pytest.mark.skipif(CHROMIUM is None, reason="there is no Chromium on this machine")
def test_the_page_of_another_rod_has_its_sliders(tmp_path):
    with served(model="partial_follower", own=(("chi", 0.9),)) as port, Browser(tmp_path / "p") as page:
        page.send("Page.navigate", url=f"http://{HOST}:{port}/")
        page.wait_for("document.querySelectorAll('#thresholds tr').length > 0")
        assert page.run("document.title").startswith("Rod 'partial_follower'")
        assert page.run("document.getElementById('title').textContent") == page.run("document.title")
        first = page.run("document.querySelector('#thresholds tr').children[1].textContent")
        asked = len(page.requests)
        for value in ("0.47", "0.48", "0.49", "0.5"):  # four changes before there is an answer
            page.run(
                f"(s => {{ s.value = {value}; s.dispatchEvent(new Event('input')); }})"
                "(document.getElementById('chi'))"
            )
        page.wait_for(f"document.querySelector('#thresholds tr').children[1].textContent !== '{first}'")
        page.wait_for("!waiting")
        chi = page.run("document.getElementById('chi-value').textContent")
        assert chi == "0.9"
        page.wait_for(f"document.querySelector('#thresholds tr').children[1].textContent === '{first}'")
        states_asked = [url for url in page.requests[asked:] if "/state" in url]
        assert 2 <= len(states_asked) <= 3
        assert "chi=0.9" in states_asked[-1]


@pytest.mark.skipif(CHROMIUM is None, reason="there is no Chromium on this machine")
def test_page_follows_the_sliders(port, tmp_path):
    def cells():
        return page.run(
            "[...document.querySelectorAll('#thresholds tr')]"
            ".map(row => [...row.children].map(cell => cell.textContent))"
        )

    with Browser(tmp_path / "profile") as page:
        page.send("Page.navigate", url=f"http://{HOST}:{port}/")
        page.wait_for("document.querySelectorAll('#thresholds tr').length === 1")
        (row,) = cells()
        (expected,) = landau(RodParameters("1e4", "1e4", "1e-4"))
        assert float(row[1]) == pytest.approx(expected.force, rel=1e-7)
        assert row[6] == "supercritical"
        # the middle of the slider for k1 is 20 (1e6/20)^0.23 where clicked
        box = page.run(
            "(r => [r.x, r.y, r.width, r.height])(document.getElementById('k1').getBoundingClientRect())"
        )
        page.click(box[0] + 0.23 * box[2], box[1] + box[3] / 2)
        page.wait_for("document.querySelectorAll('#thresholds tr').length === 2")
        k1 = page.run("document.getElementById('k1-value').textContent")
        assert 150 < float(k1) < 300
        force = page.run("document.getElementById('force-value').textContent")
        rod = RodParameters(k1, "1e4", "1e-4")
        for shown, c, p in zip(cells(), landau(rod), predict(rod, force), strict=True):
            assert float(shown[1]) == pytest.approx(c.force, rel=1e-7)
            assert float(shown[2]) == pytest.approx(c.omega, rel=1e-7)
            re = float(shown[4].split()[0].replace("−", "-"))
            assert re == pytest.approx(c.alpha.real, rel=1e-5)
            assert (shown[3], shown[6]) == (c.crossing, c.criticality)
            assert (shown[7] == "–") == (not p.exists)
        page.wait_for("document.querySelectorAll('#amplitude circle').length > 10")
        assert all(url.startswith((f"http://{HOST}:{port}/", "data:", "about:")) for url in page.requests)
        assert len(page.requests) > 3
        page.screenshot(tmp_path / "page.png")
        assert (tmp_path / "page.png").stat().st_size > 20_000
