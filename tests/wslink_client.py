"""What a browser says to a wslink server, said without a browser."""

import contextlib

import aiohttp
import msgpack
from wslink.chunking import generate_chunks


class Browser:
    """One connection; replies come by the id of what was asked."""

    def __init__(self, socket):
        self.socket = socket
        self.states = {}
        self._n = 0

    async def hello(self, secret):
        return await self._ask("system:c0:0", "wslink.hello", [{"secret": secret}])

    async def call(self, method, *args):
        self._n += 1
        return await self._ask(f"rpc:c0:{self._n}", method, list(args))

    async def set(self, **values):
        changes = [{"key": key, "value": value} for key, value in values.items()]
        return await self.call("trame.state.update", changes)

    async def trigger(self, name, *args):
        return await self.call("trame.trigger", name, list(args), {})

    async def until(self, condition, timeout=20):
        """Take what the server tells until a condition on its variables holds."""
        import asyncio

        async with asyncio.timeout(timeout):
            while not condition(self.states):
                self._take(msgpack.unpackb((await self.socket.receive()).data[12:]))
        return self.states

    async def _ask(self, rpc, method, args):
        asked = {"wslink": "1.0", "id": rpc, "method": method, "args": args}
        for chunk in generate_chunks(msgpack.packb({**asked, "kwargs": {}}), 0):
            await self.socket.send_bytes(chunk)
        while True:
            message = await self.socket.receive()
            if message.type is not aiohttp.WSMsgType.BINARY:
                raise ConnectionError(message.type.name)
            reply = msgpack.unpackb(message.data[12:])  # small: never in parts
            if reply.get("id") == rpc:
                return reply
            self._take(reply)

    def _take(self, told):
        """Note variables that the server has set."""
        if told["id"].startswith("publish:trame.state.topic"):
            self.states |= told["result"]


@contextlib.asynccontextmanager
async def connected(url, *, secret=None, origin=None, **headers):
    """Connect to the server of a link, and say its secret or another."""
    base, _, query = url.partition("/?secret=")
    own = {"Origin": base if origin is None else origin, **headers}
    async with (
        aiohttp.ClientSession() as session,
        session.ws_connect(f"{base}/ws", headers=own, max_msg_size=0) as socket,
    ):
        browser = Browser(socket)
        browser.reply = await browser.hello(query if secret is None else secret)
        yield browser
