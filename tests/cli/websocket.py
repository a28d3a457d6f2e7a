"""A small WebSocket client (RFC 6455) for tests: handshake, masking, fragments; it can also send what it should not."""

import base64
import hashlib
import json
import os
import socket
import struct

CONTINUATION, TEXT, BINARY, CLOSE, PING, PONG = 0, 1, 2, 8, 9, 10
GUID = "258EAFA5-E914-47DA-95CA-C5AB0DC85B11"


class Refused(Exception):
    """The handshake was answered with another status."""

    def __init__(self, status):
        super().__init__(status)
        self.status = status


class Closed(Exception):
    """The server closed the connection; code: why, or None."""

    def __init__(self, code):
        super().__init__(code)
        self.code = code


class WebSocket:
    def __init__(self, host, port, path, headers=None, timeout=30):
        self.socket = socket.create_connection((host, port), timeout)
        self.received = b""
        key = base64.b64encode(os.urandom(16)).decode()
        fields = {"Host": f"{host}:{port}", "Upgrade": "websocket", "Connection": "Upgrade",
                  "Sec-WebSocket-Key": key, "Sec-WebSocket-Version": "13", **(headers or {})}
        lines = [f"GET {path} HTTP/1.1", *(f"{name}: {value}" for name, value in fields.items())]
        self.socket.sendall(("\r\n".join(lines) + "\r\n\r\n").encode())
        while b"\r\n\r\n" not in self.received:
            self.receive_more()
        head, _, self.received = self.received.partition(b"\r\n\r\n")
        status = int(head.split(b" ", 2)[1])
        if status != 101:
            self.socket.close()
            raise Refused(status)
        accept = base64.b64encode(hashlib.sha1((key + GUID).encode()).digest())
        assert accept in head, head

    def receive_more(self):
        data = self.socket.recv(1 << 16)
        if not data:
            raise Closed(None)
        self.received += data

    def take(self, count):
        parts = [self.received]
        have = len(self.received)
        while have < count:
            data = self.socket.recv(1 << 20)
            if not data:
                raise Closed(None)
            parts.append(data)
            have += len(data)
        whole = b"".join(parts)
        self.received = whole[count:]
        return whole[:count]

    def send_frame(self, opcode, payload=b"", final=True, masked=True):
        size = len(payload)
        first = (0x80 if final else 0) | opcode
        mask_bit = 0x80 if masked else 0
        if size < 126:
            head = struct.pack(">BB", first, mask_bit | size)
        elif size < 1 << 16:
            head = struct.pack(">BBH", first, mask_bit | 126, size)
        else:
            head = struct.pack(">BBQ", first, mask_bit | 127, size)
        if not masked:
            self.socket.sendall(head + payload)
            return
        mask = os.urandom(4)
        body = bytes(byte ^ mask[k % 4] for k, byte in enumerate(payload))
        self.socket.sendall(head + mask + body)

    def send(self, message):
        self.send_frame(TEXT, json.dumps(message).encode())

    def receive(self):
        """The next message: an object, or the bytes of a binary message. Answers pings."""
        whole, kind = b"", None
        while True:
            first, second = self.take(2)
            assert second & 0x80 == 0, "servers do not mask"
            size = second & 0x7F
            if size == 126:
                size, = struct.unpack(">H", self.take(2))
            elif size == 127:
                size, = struct.unpack(">Q", self.take(8))
            payload = self.take(size)
            opcode = first & 0x0F
            if opcode == PING:
                self.send_frame(PONG, payload)
                continue
            if opcode == PONG:
                continue
            if opcode == CLOSE:
                raise Closed(struct.unpack(">H", payload[:2])[0] if payload else None)
            kind = kind if opcode == CONTINUATION else opcode
            whole += payload
            if first & 0x80:
                return json.loads(whole) if kind == TEXT else whole

    def close(self):
        """As a page that goes away."""
        try:
            self.send_frame(CLOSE, struct.pack(">H", 1001))
            while True:
                self.receive()
        except (Closed, OSError):
            pass
        self.socket.close()
