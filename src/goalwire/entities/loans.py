"""Loaned messages: a program writes a large sequence of numbers into memory that subscribers read.

The names are rclcpp's: `can_loan_messages`, `borrow_loaned_message`, `get`. A message's bytes are a head, the
numbers, and maybe a tail. The numbers are written by the program, into memory of the wire; the head is
encoded when the message is published, and put directly before them. So the memory has room on both sides.
"""

from __future__ import annotations

from contextlib import suppress
from types import TracebackType
from typing import TYPE_CHECKING, Generic, Self

from goalwire.cdr import codec, layout
from goalwire.entities.type_support import MsgT
from goalwire.idl.runtime import TYPECODES
from goalwire.transport.contract import Loan, PublisherPort

if TYPE_CHECKING:
    from goalwire.cdr.layout import Leaf

HEAD_ROOM = 4096
"""Bytes reserved before the numbers, for all fields before them. A message that needs more is copied."""
TAIL_ROOM = 1024
"""Bytes reserved after the numbers, for the fields after them: PointCloud2 has one."""


def loanable_fields(cls: type) -> dict[str, Leaf]:
    """Return the fields of a message class that may be lent: its sequences of numbers."""
    return {leaf.name: leaf for leaf in layout.leaves(cls) if leaf.type.is_number and leaf.type.is_sequence}


class OwnMemory:
    """Stands in for memory of the wire where there is none: the message is copied when it is published."""

    def __init__(self, size: int) -> None:
        self.view = memoryview(bytearray(size))

    def narrow(self, start: int, size: int) -> None:
        """Keep only the `size` bytes from `start` on: they are the message."""
        self.view = self.view[start : start + size]

    def end(self) -> None:
        """Do nothing: nobody else has this memory."""


def borrow(port: PublisherPort, cls: type[MsgT], lengths: dict[str, int]) -> LoanedMessage[MsgT]:
    """Return a loaned message of a class; see PublisherCore.borrow_loaned_message."""
    fields = loanable_fields(cls)
    if len(lengths) != 1 or not lengths.keys() <= fields.keys():
        raise TypeError(
            f'borrow_loaned_message() of {cls.__name__} takes the length of one sequence of numbers: '
            + (', '.join(f'{name}=1000' for name in fields) or 'the message has none, so publish it as it is')
        )
    ((field, count),) = lengths.items()
    if count < 0:
        raise ValueError(f'borrow_loaned_message(): {field}={count}, and no length is below 0')
    size = HEAD_ROOM + count * layout.SIZES[fields[field].type.base] + TAIL_ROOM
    return LoanedMessage(cls(), field, count, port.borrow(size) or OwnMemory(size))


def publish(port: PublisherPort, loaned: LoanedMessage[MsgT]) -> None:
    """Publish a loaned message, and end it. Raises ValueError if it has ended, EncodeError."""
    try:
        loan = loaned.place()
        if loan is None:
            port.publish(codec.encode(loaned.get()))
        elif isinstance(loan, OwnMemory):
            port.publish(bytes(loan.view))
        else:
            port.publish_loan(loan)
    finally:
        loaned.end()


class LoanedMessage(Generic[MsgT]):
    """A message with one field in memory of the wire. It ends when it is published, or with its block."""

    def __init__(self, message: MsgT, field: str, count: int, loan: Loan) -> None:
        """`field` gets `count` numbers in the memory of `loan`."""
        leaf = loanable_fields(type(message))[field]
        size = layout.SIZES[leaf.type.base]
        code = TYPECODES[leaf.type.base]
        self._message: MsgT | None = message
        self._loan: Loan | None = loan
        self._bytes = loan.view[HEAD_ROOM : HEAD_ROOM + count * size]
        self._numbers = self._bytes.cast(code)  # type: ignore[call-overload]
        setattr(message, f'_{field}', self._numbers)

    def get(self) -> MsgT:
        """Return the message. Raises ValueError once it was published, or its block has ended."""
        if self._message is None:
            raise ValueError('the loaned message was published or given back: borrow another one')
        return self._message

    def place(self) -> Loan | None:
        """Write the rest of the message around the numbers; None if it has no room there.

        Raises EncodeError.
        """
        loan = self._loan
        message = self.get()
        cls: type = type(message)
        parts = codec.parts_encoder(cls)(message)
        at = next((at for at, part in enumerate(parts) if part is self._numbers), None)
        if loan is None or at is None:
            return None
        head, tail = b''.join(parts[:at]), b''.join(parts[at + 1 :])
        if len(head) > HEAD_ROOM or len(tail) > TAIL_ROOM:
            return None
        end = HEAD_ROOM + len(self._bytes)
        memory = loan.view
        memory[HEAD_ROOM - len(head) : HEAD_ROOM] = head
        memory[end : end + len(tail)] = tail
        loan.narrow(HEAD_ROOM - len(head), len(head) + len(self._bytes) + len(tail))
        return loan

    def end(self) -> None:
        """Give the memory back. Idempotent; the numbers cannot be read or written any more."""
        loan, self._loan = self._loan, None
        if loan is None:
            return
        self._message = None
        for view in (self._numbers, self._bytes):
            with suppress(BufferError):  # the program still has a view of the memory
                view.release()
        loan.end()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.end()

    def __del__(self) -> None:
        self.end()
