"""Writes small Excel workbooks, as Excel does: shared texts, numbers, and cells by their address."""

import zipfile
from xml.sax.saxutils import escape

_MAIN = 'xmlns="http://schemas.openxmlformats.org/spreadsheetml/2006/main"'


def write(path, sheets):
    """Write lists of rows of texts and numbers as the sheets of a workbook."""
    texts = list(dict.fromkeys(cell for rows in sheets for row in rows for cell in row if isinstance(cell, str)))
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as book:
        items = "".join(f"<si><t>{escape(text)}</t></si>" for text in texts)
        book.writestr("xl/sharedStrings.xml", f"<sst {_MAIN}>{items}</sst>")
        for number, rows in enumerate(sheets, start=1):
            body = "".join(_row(line, row, texts) for line, row in enumerate(rows, start=1))
            book.writestr(
                f"xl/worksheets/sheet{number}.xml", f"<worksheet {_MAIN}><sheetData>{body}</sheetData></worksheet>"
            )


def _row(line, row, texts):
    cells = ""
    for column, cell in enumerate(row):
        address = f"{chr(ord('A') + column)}{line}"
        if isinstance(cell, str):
            cells += f'<c r="{address}" t="s"><v>{texts.index(cell)}</v></c>'
        else:
            cells += f'<c r="{address}"><v>{cell}</v></c>'
    return f'<row r="{line}">{cells}</row>'
