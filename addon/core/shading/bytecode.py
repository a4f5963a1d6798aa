"""Makes the OSL compiler's output shorter, for the same shader: it is most of what a material takes in a .blend."""

import re
from collections import Counter

# the source once more, folders of this machine, hints for messages of errors and of lifetimes, which OSL works out
# again when it loads a shader, and what it takes for granted: that an instruction writes its first argument and reads
# the others
_NOT_NEEDED = re.compile(r'^[ \t]*#.*\n|[ \t]*%(?:filename\{"[^"]*"\}|(?:line|read|write)\{[^}]*\}|argrw\{"wr*"\})',
                         re.MULTILINE)
_LONG_TABLE = re.compile(r"^const\tfloat\[\d{3,}\]\t\S+\t(.*)$", re.MULTILINE)
_FIGURES = 7                # of the numbers in tables: single precision has 6 to 9
_VARIABLE = re.compile(r"^(?:temp|local|const)\t[^\t]+\t((?:\$|___\d)[\w$]*)(?!.*%)", re.MULTILINE)
_BYTECODE_WORD = re.compile(r'"(?:[^"\\]|\\.)*"|[\w$.]*[A-Za-z_$][\w$.]*')
_DIGITS = "0123456789abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ"


def compact(text: str) -> str:
    """The same shader in fewer characters.

    Variables get short names, the shortest where they are used most; parameters keep theirs, and so do structures.
    Numbers of tables are rounded to _FIGURES figures, which is an error of at most 5e-7.
    """
    text = _LONG_TABLE.sub(lambda table: table[0].replace(table[1], _rounded(table[1])), _NOT_NEEDED.sub("", text))
    variables = set(_VARIABLE.findall(text))
    counts = Counter(word for word in _BYTECODE_WORD.findall(text) if word in variables)
    names = {word: f"${_number(place)}" for place, (word, _) in enumerate(counts.most_common())}
    renamed = _BYTECODE_WORD.sub(lambda word: names.get(word[0], word[0]), text)
    return re.sub(r"[ \t]+$", "", renamed, flags=re.MULTILINE)


def _rounded(numbers: str) -> str:
    return " ".join(re.sub(r"^(-?)0\.", r"\1.", f"{float(number):.{_FIGURES}g}") for number in numbers.split())


def _number(place: int) -> str:
    """A number in base 62."""
    digits = _DIGITS[place % len(_DIGITS)]
    return digits if place < len(_DIGITS) else _number(place // len(_DIGITS)) + digits
