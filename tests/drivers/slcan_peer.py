"""The far end of an slcan line, spoken by python3-can, which knows nothing of this project.

usage: slcan_peer.py send TTY   sends every identifier with every length, among frames of other kinds
       slcan_peer.py hear TTY   receives the same frames, and says what came and in what order it should have
Ends with exit code 0 when all were there, 1 and one line when not, 77 where python3-can is missing.
"""

import sys

try:
    import can
    import serial  # pylint: disable=unused-import # slcan needs it, and only warns
    from can.interfaces.slcan import slcanBus
except ImportError as missing:
    print(missing)
    sys.exit(77)

PATIENCE = 20  # seconds


def frames():
    """All identifiers and lengths; the data tells which frame it is."""
    for identifier in range(0x800):
        for length in range(9):
            yield identifier, bytes((identifier * 7 + length * 13 + i * 29) & 0xFF for i in range(length))


def send(bus):
    for identifier, data in frames():
        bus.send(can.Message(arbitration_id=identifier, data=data, is_extended_id=False))
        if identifier % 256 == 0:
            bus.send(can.Message(arbitration_id=identifier, data=data, is_extended_id=True))
            bus.send(can.Message(arbitration_id=identifier, dlc=len(data), is_remote_frame=True, is_extended_id=False))


def hear(bus):
    """The first difference, or None."""
    for count, (identifier, data) in enumerate(frames()):
        message = bus.recv(timeout=PATIENCE)
        if message is None:
            return f"frame {count} never came"
        if (message.arbitration_id, bytes(message.data)) != (identifier, data) or message.is_extended_id:
            return f"frame {count}: {message}, expected {identifier:03X} {data.hex()}"
    return None


def main():
    mode, tty = sys.argv[1:]
    bus = slcanBus(tty, sleep_after_open=0)
    print("ready", flush=True)
    fault = send(bus) if mode == "send" else hear(bus)
    bus.shutdown()
    if fault:
        print(fault)
    return 1 if fault else 0


if __name__ == "__main__":
    sys.exit(main())
