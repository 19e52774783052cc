"""A capitalised name in a comment, such as a constant's, exists in the code: comments follow when names change."""

import pathlib
import re
import subprocess

ROOT = pathlib.Path(__file__).resolve().parents[2]
PARTS = ("anatomy", "common", "data_synthetic", "flow", "reports", "vci", "whatif", "workflow")
# Strings are matched so that a # or // within them begins no comment. A text in three quotes that begins its line
# counts as a docstring.
DOCSTRING, TEXT = r'(?P<docstring>^[ \t]*[rR]?""".*?""")', r'"(?:\\.|[^"\\\n])*"'
TOKENS = {
    ".py": rf"{DOCSTRING}|(?P<comment>#[^\n]*)|" + r'""".*?"""|' + rf"{TEXT}|'(?:\\.|[^'\\\n])*'",
    ".cpp": rf"(?P<comment>//[^\n]*|/\*.*?\*/)|R\"\(.*?\)\"|{TEXT}|'\\?.'",
}
TOKENS = {suffix: re.compile(pattern, re.DOTALL | re.MULTILINE) for suffix, pattern in TOKENS.items()}
TOKENS[".hpp"] = TOKENS[".cpp"]
NAME = re.compile(r"\b(?=\w*[A-Z]\w*[A-Z])[A-Z][A-Z0-9_]*\b")  # two capitals or more, no small letter
# Words that no code has: programs, formats, methods, medicine, journals and trials, placeholders.
WORDS = """
    AIJ AVX AVX2 CSR FCL HXT LZ4 LZMA NOLINT UFL VTK_DOUBLE
    ASCII HTML IEEE ISO NRRD OBJ README RO SI URI VTP
    AIC BDF2 EI ERR FFT MSER NLEQ PCG PN
    DBP IVUS LCX RCA SBP
    ACC ACM EACTS EAPCI ESC I3D III ONE SYNTAX TBME TVCG ULTIMATE
    DEVICE SCENE
""".split()


def sources():
    """{name: text} of the parts' C++ and Python files, those not yet added to version control included."""
    patterns = [f"{part}/*{suffix}" for part in PARTS for suffix in TOKENS]
    command = ["git", "ls-files", "--cached", "--others", "--exclude-standard", "--", *patterns]
    names = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True).stdout.split("\n")
    return {name: (ROOT / name).read_text() for name in names if name and (ROOT / name).is_file()}


def split_comments(name, text):
    """(comments and docstrings as [(line, text)], the rest of a source)."""
    comments = []

    def cut(match):
        if not match.lastgroup:
            return match[0]
        comments.append((1 + text.count("\n", 0, match.start()), match[0]))
        return " "

    code = TOKENS[pathlib.PurePath(name).suffix].sub(cut, text)
    return comments, code


def stale_names(texts):
    """Capitalised names in the comments of {file's name: text} that the code of none of the files has."""
    split = {name: split_comments(name, text) for name, text in texts.items()}
    known = set(WORDS).union(*(re.findall(r"\w+", code) for _, code in split.values()))
    return [
        f"{name}:{line + comment.count(chr(10), 0, word.start())}: {word[0]}"
        for name, (comments, _) in split.items()
        for line, comment in comments
        for word in NAME.finditer(comment)
        if word[0] not in known
    ]


def test_comments_name_what_exists():
    """Add a word to WORDS only if it is no name of ours."""
    texts = sources()
    wrong = stale_names(texts)
    assert {pathlib.PurePath(name).suffix for name in texts} == set(TOKENS) and not wrong, "\n".join(wrong)


def test_a_stale_name_is_found():
    """Comments, docstrings and ends of lines count; a name that any file's code or strings have is known."""
    python = '"""One.\n\nLEAST_A times."""\nB_MM = 1  # below MOST_A\nprint("# not C_MM", \'"\')  # FILE_D, C_MM\n'
    cpp = 'int a = 1\'000; // B_MM is OLD\n/* both\n   TWO_B */\nconst char* b = "// FILE_D"; ///< README, A or Ab\n'
    found = stale_names({"a.py": python, "b.hpp": cpp})
    assert found == ["a.py:3: LEAST_A", "a.py:4: MOST_A", "b.hpp:1: OLD", "b.hpp:3: TWO_B"]
    assert not stale_names({"a.py": python + "LEAST_A, MOST_A, OLD = 1, 2, 3\n", "b.cpp": cpp + "int TWO_B;\n"})
