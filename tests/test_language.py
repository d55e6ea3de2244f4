"""The language of the project: a glossary made of one table, words to avoid that get fewer, and short sentences."""

import ast
import re
import runpy
import shlex
from pathlib import Path

import click
import pytest

from clearsweep.cli import verbs
from clearsweep.language import quantity

ROOT = Path(__file__).parents[1]
GLOSSARY = runpy.run_path(str(ROOT / "docs/tools/glossary.py"))
MOST = 25  # words in a sentence
UNITS = set(quantity.COMMON_UNITS.split())  # a list of them is no sentence


def test_the_glossary_is_made_from_its_table():
    assert GLOSSARY["PAGE"].read_text(encoding="utf-8") == GLOSSARY["page"]()


def test_no_room_uses_more_words_to_avoid_than_recorded():
    assert GLOSSARY["exceeded"](GLOSSARY["counts"](), GLOSSARY["recorded"]()) == []


def test_an_added_word_to_avoid_is_counted(tmp_path):
    source = tmp_path / "clearsweep/grid"
    source.mkdir(parents=True)
    (source / "keys.py").write_text('found = 1  # one stands beside it\nresult = "found"\n', encoding="utf-8")
    identifiers, text = GLOSSARY["words"](source / "keys.py")
    assert identifiers["found"] == 1
    assert GLOSSARY["occurrences"](text) == 2
    count = GLOSSARY["Count"]
    assert GLOSSARY["exceeded"]({"grid": count(2, 0)}, {"grid": count(1, 0)}) != []
    assert GLOSSARY["lowered"]({"grid": count(2, 0)}, {"grid": count(1, 3)}) == {"grid": (1, 0)}


def written(node):
    """Return the text of a string, `X` in the place of what is filled in; None for any other expression."""
    if isinstance(node, ast.Constant) and isinstance(node.value, str):
        return node.value
    if isinstance(node, ast.JoinedStr):
        return "".join(written(part) or "X" for part in node.values)
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Add):
        parts = written(node.left), written(node.right)
        return None if parts == (None, None) else "".join(part or "X" for part in parts)
    return None


def strings(tree):
    """Yield (line, text) of every string in a module but docstrings."""
    described = (ast.Module, ast.FunctionDef, ast.ClassDef)
    docstrings = {node.body[0].value for node in ast.walk(tree) if isinstance(node, described) and node.body[0:1]
                  and isinstance(node.body[0], ast.Expr)}  # fmt: skip
    pending = [tree]
    while pending:
        node = pending.pop()
        if node in docstrings:
            continue
        if (text := written(node)) is not None:
            yield node.lineno, text
        else:
            pending.extend(ast.iter_child_nodes(node))


def sentences(text):
    """Return the sentences of a text; in messages a semicolon ends one, and formulas are none."""
    parts = re.split(r"(?<=[.?!:])\s+(?=[A-Z\"'`(])|;\s|\n", text)
    return [part for part in parts if " = " not in part]


def length(sentence):
    """Return how many words a sentence has."""
    return sum(bool(re.search(r"[A-Za-z]{2}|\d|^[aIX]$", word)) for word in sentence.split())


def longer(text):
    """Return the sentences of a text that are too long; a list of units, or a table of numbers, is none."""
    if len(text.split()) <= MOST:  # most texts
        return []
    long = [sentence for sentence in sentences(text) if length(sentence) > MOST and set(sentence.split()) - UNITS]
    return [sentence for sentence in long if not re.fullmatch(r"(\w\s)?[\da-f\s]+", sentence)]


def test_sentences_of_messages_are_short():
    """Every string of the package counts: messages, help, closing lines, descriptions of laws and columns."""
    assert [
        f"{path.relative_to(ROOT)}:{line}: {each}"
        for path in sorted((ROOT / "clearsweep").rglob("*.py"))
        for line, text in strings(ast.parse(path.read_text(encoding="utf-8")))
        for each in longer(text)
    ] == []
    texts = sorted((ROOT / "clearsweep").rglob("*.md"))
    assert [each for path in texts for each in longer(path.read_text(encoding="utf-8"))] == []


@pytest.mark.parametrize("name", [None, *verbs.commands])
def test_sentences_of_help_are_short(name):
    command = verbs.commands[name] if name else verbs
    texts = [command.help or "", *(option.help or "" for option in command.params if isinstance(option, click.Option))]
    assert [each for text in texts for each in longer(re.sub(r"(?<!\n)\n(?!\n)", " ", text))] == []


def test_every_example_of_help_is_a_command_that_parses():
    examples = re.findall(
        r"^ *clearsweep (.*)$", "\n".join(verb.help for verb in verbs.commands.values()), re.MULTILINE
    )
    assert len(examples) >= 6
    for words in map(shlex.split, examples):
        verbs.commands[words[0]].make_context(words[0], words[1:])


def prose(markdown):
    """Return the text of a page without fenced blocks, tables, pictures and the marks of lists and links."""
    text = re.sub(r"^```.*?^```$|^\|.*?$|<!--.*?-->|^#.*?$", "", markdown, flags=re.MULTILINE | re.DOTALL)
    text = re.sub(r"!\[.*?\]\(.*?\)", "", text)
    text = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", text)
    paragraphs = re.split(r"\n\s*\n|\n(?=\s*(?:[*-]|\d+\.) )", text)
    return "\n".join(" ".join(paragraph.split()) for paragraph in paragraphs)


PAGES = [
    page.relative_to(ROOT).as_posix()
    for page in (ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md")))
]


@pytest.mark.parametrize("page", PAGES)
def test_sentences_of_a_page_are_short(page):
    assert longer(prose((ROOT / page).read_text(encoding="utf-8"))) == []


@pytest.mark.parametrize("page", PAGES)
def test_a_page_uses_no_word_to_avoid(page):
    quoted = re.sub(r"\*[a-z ]+\*", "", prose((ROOT / page).read_text(encoding="utf-8")))  # words that a command prints
    assert GLOSSARY["occurrences"](quoted) == 0


def test_a_long_sentence_is_found():
    assert longer("Word " * 26) != []
    assert longer("Word " * 13 + "end. " + "Word " * 13) == []
    assert longer(prose("* " + "word " * 13 + "\n* " + "word " * 13)) == []
