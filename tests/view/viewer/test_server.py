"""Who gets in, what they may do, and how it ends: over real sockets."""

import asyncio
import contextlib
import dataclasses
import socket
from urllib.parse import urlsplit

import aiohttp
import msgpack
import pytest
from wslink.chunking import generate_chunks
from wslink_client import connected

from skinviz.errors import SkinvizError
from skinviz.view.viewer import app
from skinviz.view.viewer.guard import LARGEST_MESSAGE, is_known_name
from skinviz.view.viewer.opened import open_path
from skinviz.view.viewer.server import start

REFUSED = (ConnectionError, aiohttp.WSServerHandshakeError)


@pytest.fixture
def run(opened, tmp_path):
    """Run a test's coroutine with a server that shows the ball in its own folder."""

    def ran(talk, **options):
        async def served():
            own = dataclasses.replace(opened, folder=tmp_path)
            running = start(**options)
            try:
                async with asyncio.timeout(60):
                    await running.answering()
                    await running.show(lambda: own)
                    await talk(running)
            finally:
                await running.stop()

        asyncio.run(served())

    return ran


async def status(url, **options):
    """Return the status of a request and its headers."""
    async with aiohttp.ClientSession() as session, session.get(url, **options) as reply:
        return reply.status, reply.headers


def base_of(running):
    return running.url.partition("/?")[0]


# Who gets in ------------------------------------------------------------------


def test_it_listens_on_this_machine_alone_with_a_secret_of_its_own(run):
    seen = []

    async def talk(running):
        parts = urlsplit(running.url)
        assert parts.hostname == "127.0.0.1"
        secret = parts.query.removeprefix("secret=")
        assert len(secret) >= 40
        seen.append(secret)
        with pytest.raises(ConnectionRefusedError):
            # All of 127/8 is this machine, but only one address is listened on.
            socket.create_connection(("127.0.0.2", parts.port), timeout=2)

    run(talk)
    run(talk)
    assert seen[0] != seen[1]


def test_the_secret_opens_and_nothing_else_does(run):
    async def talk(running):
        async with connected(running.url) as browser:
            assert "clientID" in browser.reply["result"]
        for wrong in ("wslink-secret", "", None, 5, "x" * 43, ["a"], {"a": 1}):
            async with connected(running.url, secret=wrong or "") as browser:
                assert browser.reply["error"]["message"] == "Authentication failed"
                reply = await browser.call("trame.state.get")
                assert "Unauthorized" in reply["error"]["message"]
                reply = await browser.trigger("reset")
                assert "Unauthorized" in reply["error"]["message"]

    run(talk)


@pytest.mark.parametrize(
    "origin",
    [
        "http://evil.example",
        "https://evil.example:443",
        "http://localhost:1",
        "http://127.0.0.1",
        "null",
        "http://[",
        "",
    ],
)
def test_pages_of_other_sites_do_not_get_in(run, origin):
    async def talk(running):
        with pytest.raises(aiohttp.WSServerHandshakeError) as refused:
            async with connected(running.url, origin=origin):
                pass
        assert refused.value.status == 403
        code, _ = await status(
            base_of(running) + "/index.html", headers={"Origin": origin}
        )
        assert code == 403

    run(talk)


def test_without_an_origin_no_socket_is_opened(run):
    async def talk(running):
        async with aiohttp.ClientSession() as session:
            with pytest.raises(aiohttp.WSServerHandshakeError) as refused:
                await session.ws_connect(base_of(running) + "/ws")
        assert refused.value.status == 403

    run(talk)


@pytest.mark.parametrize(
    "host", ["evil.example", "evil.example:{port}", "10.0.0.1", "a b"]
)
def test_names_that_were_made_to_stand_for_this_machine_are_refused(run, host):
    """DNS rebinding: the page's own site, its name now that of 127.0.0.1."""

    async def talk(running):
        named = host.format(port=urlsplit(running.url).port)
        code, _ = await status(
            base_of(running) + "/index.html", headers={"Host": named}
        )
        assert code in (400, 403)
        with pytest.raises(aiohttp.WSServerHandshakeError) as refused:
            async with connected(running.url, origin=f"http://{named}", Host=named):
                pass
        assert refused.value.status in (400, 403)

    run(talk)


def test_a_tunnel_with_another_port_gets_in(run):
    async def talk(running):
        host = "localhost:9999"
        async with connected(
            running.url, origin=f"http://{host}", Host=host
        ) as browser:
            assert "clientID" in browser.reply["result"]

    run(talk)


@pytest.mark.parametrize(
    ("name", "host", "known"),
    [
        ("127.0.0.1:80", "127.0.0.1", True),
        ("localhost", "127.0.0.1", True),
        ("[::1]:80", "127.0.0.1", True),
        ("192.168.0.7", "127.0.0.1", False),
        ("localhost.evil.example", "127.0.0.1", False),
        ("", "127.0.0.1", False),
        ("[::1", "127.0.0.1", False),
        ("192.168.0.7:80", "0.0.0.0", True),
        (socket.gethostname(), "0.0.0.0", True),
        ("evil.example", "0.0.0.0", False),
        ("lab.example", "lab.example", True),
    ],
)
def test_names_of_the_server(name, host, known):
    assert is_known_name(name, host) is known


def test_a_reloaded_page_is_known_by_its_cookie(run):
    async def talk(running):
        base = base_of(running)
        async with (
            aiohttp.ClientSession(cookie_jar=aiohttp.CookieJar(unsafe=True)) as session,
            session.get(running.url) as reply,
        ):
            assert reply.status == 200
            (cookie,) = reply.cookies.values()
            assert cookie["httponly"]
            assert cookie["samesite"] == "Strict"
        headers = {"Cookie": f"{cookie.key}={cookie.value}"}
        async with connected(running.url, secret="wslink-secret", **headers) as browser:
            assert "clientID" in browser.reply["result"]
        _, told = await status(base + "/index.html?secret=wrong")
        assert "Set-Cookie" not in told

    run(talk)


def test_pages_may_not_be_framed_or_leak_the_link(run):
    async def talk(running):
        _, headers = await status(base_of(running) + "/index.html")
        policy = headers["Content-Security-Policy"]
        assert "frame-ancestors 'none'" in policy
        (allowed,) = (p for p in policy.split("; ") if p.startswith("connect-src"))
        here = urlsplit(running.url).netloc
        assert allowed == f"connect-src 'self' ws://{here} wss://{here}"
        assert headers["Referrer-Policy"] == "no-referrer"

    run(talk)

    async def framed(running):
        _, headers = await status(base_of(running) + "/index.html")
        assert "http://localhost:*" in headers["Content-Security-Policy"]

    run(framed, framed=True)


# What they may do -------------------------------------------------------------


@pytest.mark.parametrize(
    "path",
    [
        "/../../../etc/passwd",
        "/..%2f..%2f..%2fetc/passwd",
        "/skinviz/../server.py",
        "/skinviz/%2e%2e/server.py",
        "/skinviz/..%2fserver.py",
        "/ball.ply",
        "/skinviz/",
    ],
)
def test_no_file_of_the_machine_is_served(run, path):
    async def talk(running):
        parts = urlsplit(running.url)
        reader, writer = await asyncio.open_connection(parts.hostname, parts.port)
        asked = (
            f"GET {path} HTTP/1.1\r\nHost: {parts.netloc}\r\nConnection: close\r\n\r\n"
        )
        writer.write(asked.encode())
        reply = await reader.read()
        writer.close()
        assert reply.split()[1] in (b"403", b"404"), reply[:200]

    run(talk)


@pytest.mark.parametrize(
    "name", ["../x.png", "/etc/x.png", "a/b.png", "漢" * 90 + ".png", 3, None, {"a": 1}]
)
def test_no_file_outside_the_folder_is_written(run, name, tmp_path):
    async def talk(running):
        async with connected(running.url) as browser:
            await browser.until(lambda told: "picture" in told)
            await browser.trigger("save_figure", name)
            await browser.until(lambda told: told.get("notice"))
            assert browser.states["notice"]["bad"]

    run(talk)
    assert not list(tmp_path.rglob("*"))


def test_a_message_that_is_too_large_ends_only_its_own_connection(run):
    async def talk(running):
        async with connected(running.url) as steady:
            for n_bytes in (LARGEST_MESSAGE + 1000, 2**32 - 1):
                async with connected(running.url) as browser:
                    # Only the head of a message that is said to be so long.
                    head = (7).to_bytes(4, "little") + (0).to_bytes(4, "little")
                    await browser.socket.send_bytes(
                        head + n_bytes.to_bytes(4, "little") + b"x"
                    )
                    with contextlib.suppress(*REFUSED):
                        await browser.trigger("reset")
                        pytest.fail("the connection is still open")
            async with connected(running.url) as browser:
                await browser.socket.send_bytes(b"x" * (LARGEST_MESSAGE + 10000))
                with pytest.raises(REFUSED):
                    await browser.trigger("reset")
            async with connected(running.url) as browser:
                for i in range(40):  # begun and never ended
                    head = (100 + i).to_bytes(4, "little") + (0).to_bytes(4, "little")
                    await browser.socket.send_bytes(
                        head + (1000).to_bytes(4, "little") + b"x"
                    )
                with pytest.raises((*REFUSED, aiohttp.ClientError)):
                    await browser.trigger("reset")
            reply = await steady.trigger("reset")
            assert "result" in reply

    run(talk)


def test_nonsense_ends_nothing(run):
    """Whatever a browser sends, the others go on."""
    nonsense = [
        ("preset", ["90/90"]),
        ("preset", []),
        ("preset", [{"a": 1}]),
        ("drag", ["turn", "a", None]),
        ("drag", ["turn", 1e300, 0.0]),
        ("drag", ["fly", 0.0, 0.0]),
        ("zoom", [float("nan")]),
        ("pick", [2.0, -1.0, True]),
        ("pick", [None]),
        ("link", ["?nothing=1"]),
        ("link", [5]),
        ("link", ["?" + "a" * 100_000]),
        ("resize", [-5, 1e9]),
        ("resize", ["wide", "high"]),
        ("save_scene", ["../x.toml"]),
        ("no_such_request", []),
    ]
    variables = [
        {"illuminant": "moonshine"},
        {"illuminant": 7},
        {"surface": "glass"},
        {"surface": {"a": 1}},
        {"width": 1e308},
        {"index": "0.1"},
        {"stops": "bright"},
        {"stops": 1e6},
        {"tolerance_log": [1]},
        {"hands": 3},
        {"hands": None},
        {"active": 9},
        {"weight_0": "dark"},
        {"weight_0": -1},
        {"weight_7": 1},
        {"saturation": 5},
        {"saturation": "much"},
        {"person": "Nobody/0"},
        {"person": 3},
        {"site": "nose"},
        {"group": 4},
        {"picture": "data:,"},
    ]

    async def talk(running):
        async with connected(running.url) as steady, connected(running.url) as rude:
            await steady.until(lambda told: "picture" in told)
            for name, given in nonsense:
                await rude.trigger(name, *given)
            for values in variables:
                await rude.set(**values)
            await rude.call("no.such.method", 1)
            await rude.call("application.exit")
            await rude.call("application.exit.later", 0)
            await rude.socket.send_str("text")
            chunks = generate_chunks(msgpack.packb({"id": "rpc:c0:9"}), 0)
            for chunk in chunks:
                await rude.socket.send_bytes(chunk)
            await asyncio.sleep(0.5)
            await steady.trigger("reset")
            await steady.set(light_angle=21)
            await steady.until(lambda told: "light=21" in told.get("query", ""))
        assert running.viewer.state.light[0] == 21

    run(talk)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("hands", 10**9),  # not as many looks as fill memory
        ("hands", 3),
        ("stops", 1e6),
        ("stops", float("nan")),
        ("tolerance_log", 1e6),
        ("width", 1e308),
        ("surface", "glass"),
        ("person", "Nobody/0"),
        ("weight_0", 1e300),
    ],
)
def test_a_control_that_was_set_beyond_its_range_goes_back(run, name, value):
    async def talk(running):
        async with connected(running.url) as browser:
            await browser.until(lambda told: told.get("still"))
            before = (await browser.call("trame.state.get"))["result"]["state"][name]
            browser.states.pop(name, None)
            await browser.set(**{name: value})
            await browser.until(lambda told: told.get("notice") and name in told)
            assert browser.states["notice"]["bad"]
            assert browser.states[name] == before
        assert running.viewer.state == running.viewer.opened.initial

    run(talk)


def test_what_cannot_be_shown_is_told_and_undone(run):
    async def talk(running):
        async with connected(running.url) as browser:
            await browser.until(lambda told: "picture" in told)
            await browser.set(index="0.3")
            await browser.until(lambda told: told.get("notice"))
            assert browser.states["notice"]["bad"]
            await browser.until(lambda told: told.get("index") == "1.4")
        assert running.viewer.state == running.viewer.opened.initial

    run(talk)


def test_after_what_cannot_be_shown_a_still_picture_follows(run):
    async def talk(running):
        async with connected(running.url) as browser:
            await browser.until(lambda told: told.get("still"))
            await browser.set(light_angle=21)
            await browser.until(lambda told: "light=21" in told.get("query", ""))
            await browser.set(index="0.3")  # before the still one is begun
            await browser.until(lambda told: told.get("notice"))
            await browser.until(lambda told: told.get("still"))
        assert running.viewer.state.light[0] == 21

    run(talk)


# One view for all -------------------------------------------------------------


def test_a_second_browser_joins_the_view_and_is_told_of(run):
    async def talk(running):
        async with connected(running.url) as first:
            await first.until(lambda told: "picture" in told)
            await first.set(light_angle=33)
            await first.until(lambda told: "light=33" in told.get("query", ""))
            async with connected(running.url) as second:
                joined = (await second.call("trame.state.get"))["result"]["state"]
                assert joined["light_angle"] == 33
                assert joined["picture"].startswith("data:image/")
                await first.until(lambda told: told.get("browsers") == 2)
                await second.set(illuminant="A")
                for browser in (first, second):
                    await browser.until(
                        lambda told: (
                            "illuminant=A" in told.get("query", "")
                            and told.get("still")
                        )
                    )
                assert first.states["picture"] == second.states["picture"]
                assert first.states["illuminant"] == "A"
            await first.until(lambda told: told.get("browsers") == 1)

    run(talk)


def test_a_slider_that_moves_fast_is_never_behind(run):
    """The last of many moves is what is shown, and not each is drawn."""

    async def talk(running):
        async with connected(running.url) as browser:
            await browser.until(lambda told: "picture" in told)
            for angle in range(80):
                await browser.set(light_angle=angle)
            await browser.until(lambda told: "light=79" in told.get("query", ""))
            await browser.until(lambda told: told.get("still"))
            assert running.viewer.state.light[0] == 79
            await browser.trigger("undo")
            assert running.viewer.state == running.viewer.opened.initial

    run(talk)


def test_work_that_takes_long_is_told_of(run, monkeypatch):
    monkeypatch.setattr(app, "_BUSY_AFTER", 0.0)

    async def talk(running):
        async with connected(running.url) as browser:
            await browser.until(lambda told: told.get("still"))
            await browser.trigger("save_figure", "view.png")
            await browser.until(lambda told: told.get("busy"))
            await browser.until(lambda told: told.get("notice"))
            await browser.until(lambda told: not told["busy"])
            assert not browser.states["notice"]["bad"]

    run(talk)


def test_a_fault_while_saving_is_told(run, monkeypatch):
    def fail(*_):
        raise RuntimeError("no ink")

    monkeypatch.setattr(app, "save_view_figure", fail)

    async def talk(running):
        async with connected(running.url) as browser:
            await browser.until(lambda told: told.get("still"))
            await browser.trigger("save_figure", "view.png")
            await browser.until(lambda told: told.get("notice"))
            assert "no ink" in browser.states["notice"]["text"]

    run(talk)


def test_a_link_shows_the_same_view(run):
    async def talk(running):
        async with connected(running.url) as browser:
            await browser.trigger("link", "?secret=x&view=30.0,10.0,0.0&illuminant=A")
            await browser.until(lambda told: "illuminant=A" in told.get("query", ""))
            assert running.viewer.state.view == (30.0, 10.0, 0.0)

    run(talk)


# How it ends -------------------------------------------------------------------


def test_a_port_in_use_is_said():
    async def twice(port):
        start(port=port)

    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        with pytest.raises(SkinvizError, match="--port"):
            asyncio.run(twice(port))


@pytest.mark.parametrize("host", ["192.0.2.1", "a host without a name"])
def test_an_address_that_is_not_of_this_machine_is_said(host):
    async def elsewhere():
        start(host=host)

    with pytest.raises(SkinvizError, match="--host"):
        asyncio.run(elsewhere())


def test_what_cannot_be_opened_is_told_on_the_page(scene_file):
    async def talk():
        running = start()
        await running.answering()
        missing = scene_file.with_name("nowhere.toml")
        with pytest.raises(SkinvizError, match="no such file"):
            await running.show(lambda: open_path(missing))
        with pytest.raises(SkinvizError):
            _ = running.viewer
        async with connected(running.url) as browser:
            told = (await browser.call("trame.state.get"))["result"]["state"]
            assert "no such file" in told["title"]
        await running.stop()

    asyncio.run(talk())


def test_it_ends_while_browsers_look_on(run):
    async def talk(running):
        async with connected(running.url) as browser:
            await browser.until(lambda told: "picture" in told)
            await running.viewer.close()

    run(talk)
