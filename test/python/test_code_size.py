"""bench/code_size.py: what counts as code, a constant, a long function."""

import code_size

CPP = """// A comment.
#include <cmath>

/* Two
   lines. */
constexpr double kLimit = 0.3;  // m

int twice(int a) {
  if (a > 2) {
    return 4 * a;
  }
  return a;
}
"""
PYTHON = '''"""A docstring
of two lines."""

def one() -> int:
    # A comment.
    return 1


TEXT = """two
lines"""
'''


def test_comments_blanks_and_docstrings_are_no_code() -> None:
    assert code_size.code_lines(CPP, python=False) == 8
    assert code_size.code_lines(PYTHON, python=True) == 4


def test_numbers_that_need_a_reason() -> None:
    assert code_size.numbers(CPP) == 2  # 0.3 and 4


def test_functions_are_found_and_statements_are_not() -> None:
    assert list(code_size.function_lengths(CPP, python=False)) == [6]
    assert list(code_size.function_lengths(PYTHON, python=True)) == [3]
