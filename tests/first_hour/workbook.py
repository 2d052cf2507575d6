#!/usr/bin/env python3
"""usage: workbook.py TABLE.csv BOOK.xlsx    A table with semicolons as Excel saves it in its own format: texts shared, numbers as numbers."""
import csv, re, sys, zipfile
from xml.sax.saxutils import escape

rows = list(csv.reader(open(sys.argv[1], encoding="utf-8"), delimiter=";"))
texts = []


def cell(place, text):
    number = text.replace(",", ".")
    if re.fullmatch(r"-?\d+(\.\d+)?", number):
        return f'<c r="{place}"><v>{number}</v></c>'
    texts.append(escape(text))
    return f'<c r="{place}" t="s"><v>{len(texts) - 1}</v></c>'


xml = "".join(f'<row r="{r}">' + "".join(cell(f"{chr(65 + c)}{r}", text) for c, text in enumerate(row) if text) + "</row>"
              for r, row in enumerate(rows, 1))
main = 'xmlns="http://schemas.openxmlformats.org/spreadsheetml/2006/main"'
office = "http://schemas.openxmlformats.org/officeDocument/2006/relationships"
package = "http://schemas.openxmlformats.org/package/2006/relationships"
with zipfile.ZipFile(sys.argv[2], "w", zipfile.ZIP_DEFLATED) as book:
    book.writestr("xl/workbook.xml", f'<workbook {main} xmlns:r="{office}"><sheets><sheet name="Tabelle1" sheetId="1" r:id="rId1"/></sheets></workbook>')
    book.writestr("xl/_rels/workbook.xml.rels", f'<Relationships xmlns="{package}"><Relationship Id="rId1" Type="{office}/worksheet" Target="worksheets/sheet1.xml"/></Relationships>')
    book.writestr("xl/worksheets/sheet1.xml", f"<worksheet {main}><sheetData>{xml}</sheetData></worksheet>")
    book.writestr("xl/sharedStrings.xml", f"<sst {main}>" + "".join(f"<si><t>{text}</t></si>" for text in texts) + "</sst>")
