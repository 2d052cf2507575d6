#!/usr/bin/env python3
"""Prints the report of a simulated site with Chromium and looks for every number of the page in the text of the PDF, for
the sheets' head and for names that are broken; and opens it with and without WebGL.

    printed_report.py PLUMBLINE     exit code 77: Chromium or pdftotext is not here
"""
import collections
import html.parser
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

SITE = """plumbline: 1
nodes:
  site: {use: simulate.campaign, with: {floors: 2, photographs: observed}}
outputs: {campaign: site.folder}
"""
SUBTITLE = "simulated facade"
NUMBER = re.compile(r"[-+]?\d+(?:[.,]\d+)*")


class VisibleText(html.parser.HTMLParser):
    """Text of all elements but scripts and styles; what is folded counts, because printing unfolds it."""

    def __init__(self):
        super().__init__()
        self.hidden = 0
        self.pieces = []

    def handle_starttag(self, tag, attributes):
        self.hidden += tag in ("script", "style", "title")

    def handle_endtag(self, tag):
        self.hidden -= tag in ("script", "style", "title")

    def handle_data(self, data):
        if not self.hidden:
            self.pieces.append(data)


def numbers(text):
    return collections.Counter(NUMBER.findall(text.replace("\u2212", "-").replace("\u00a0", " ")))


def view_in_space(chromium, page, environment, *options):
    """Whether three.js has drawn, and whether any view is there, after the page's scripts have run. Twenty seconds of the
    browser's clock, which does not wait for the process that draws: on a busy machine that may be late, hence three tries."""
    for _ in range(3):
        found = view_once(chromium, page, environment, *options)
        if found[0]:
            break
    return found


def view_once(chromium, page, environment, *options):
    dom = subprocess.run([chromium, "--headless", "--no-sandbox", "--disable-dev-shm-usage", *options, "--window-size=1200,9000",
                          "--virtual-time-budget=20000", "--dump-dom", f"file://{page}"], check=True, env=environment, text=True,
                         capture_output=True).stdout
    tag = lambda pattern: re.search(pattern, dom).group(0)
    drawn = 'id="canvas-space"' in dom and "hidden" not in tag(r'<label class="tick"[^>]*><input id="design-input"')
    return drawn, "hidden" not in tag(r'<figure id="space"[^>]*>')


def on_paper_of(chromium, work, name, environment):
    """The text of a page of the run, as printed."""
    subprocess.run([chromium, "--headless", "--no-sandbox", "--disable-gpu", f"--user-data-dir={work}/profile",
                    "--no-pdf-header-footer", f"--print-to-pdf={work}/{name}.pdf", f"file://{work}/out/{name}.html"],
                   check=True, env=environment, stderr=subprocess.DEVNULL)
    return subprocess.run(["pdftotext", "-layout", str(work / (name + ".pdf")), "-"], check=True, text=True,
                          capture_output=True).stdout


def main():
    chromium = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
    if not chromium or not shutil.which("pdftotext"):
        print("skipped: this test needs chromium and pdftotext (apt install chromium poppler-utils)")
        return 77
    with tempfile.TemporaryDirectory() as folder:
        work = pathlib.Path(folder)
        environment = dict(os.environ, PLUMBLINE_STORE=str(work / "store"), HOME=folder)
        run = lambda *command: subprocess.run(command, check=True, env=environment, stdout=subprocess.DEVNULL)
        (work / "site.yaml").write_text(SITE)
        run(sys.argv[1], "run", str(work / "site.yaml"), "--out", str(work / "site"))
        run(sys.argv[1], "run", "site_observations", f"folder={work}/site/campaign", "--out", str(work / "out"))
        printed, sheets = (on_paper_of(chromium, work, name, environment) for name in ("report", "sheets"))
        views = [view_in_space(chromium, work / "out" / "report.html", environment, f"--user-data-dir={work}/{name}", option)
                 for name, option in (("with", "--use-angle=swiftshader"), ("without", "--disable-3d-apis"))]
        page = VisibleText()
        page.feed((work / "out" / "report.html").read_text(encoding="utf-8"))
        plates = (work / "site/campaign/plates.csv").read_text(encoding="utf-8").splitlines()[1:]
    on_page, on_paper = numbers(" ".join(page.pieces)), numbers(printed)
    missing = {number: (count, on_paper[number]) for number, count in on_page.items() if on_paper[number] < count}
    print(f"{sum(on_page.values())} numbers on the page, {len(missing)} of them less often in the PDF")
    for number, (page_count, paper_count) in sorted(missing.items())[:40]:
        print(f"  {number}: {page_count} times on the page, {paper_count} times on paper")
    print(f"view in space (by three.js, any): {views[0]} with WebGL, {views[1]} without")
    wrong = views != [(True, True), (False, True)]
    for name in sorted({line.split(",")[0] for line in plates}):
        if "Anchor " + name not in sheets:
            wrong = True
            print(f"{name} is not in one piece on the sheets")
    if SUBTITLE not in printed.splitlines()[0] or not re.search(r"\b1 / \d+\s*$", printed.split("\f")[0]):
        wrong = True
        print("no head with the campaign, or no page number: " + printed.splitlines()[0])
    return 1 if wrong or missing or sum(on_page.values()) < 1000 else 0


if __name__ == "__main__":
    sys.exit(main())
