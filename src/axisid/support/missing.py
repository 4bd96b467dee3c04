"""The one way to say that something cannot be told: in place of it, with the reason."""

from dataclasses import dataclass

from .remedy import Note, Remedy


@dataclass(frozen=True, slots=True)
class Missing:
    """What stands in place of something that could not be measured, drawn or computed.

    Attributes
    ----------
    reason : str
        Why, as the end of a sentence: ``"the axis declares no control law"``.
    remedy : Remedy or None
        How the sentence goes on, where something can be set to have it.
    """

    reason: str
    remedy: Remedy | None = None

    @classmethod
    def of(cls, note: Note) -> "Missing":
        """What is missing for the reason that a note gives."""
        return cls(note.text, note.remedy)

    @property
    def note(self) -> Note:
        """The reason, to be worded later."""
        return Note(self.reason, self.remedy)

    def __str__(self) -> str:
        return str(self.note)
