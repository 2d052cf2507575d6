"""usage: test_site.py PLUMBLINE ROOT     scripts/docs makes the site without a warning, every page of docs/ is in it and in its menu, and every
link of every built page leads to a file and an anchor that are there."""
import html.parser
import os
import pathlib
import shutil
import subprocess
import sys
import urllib.parse


PROGRAM, ROOT = os.path.abspath(sys.argv[1]), pathlib.Path(sys.argv[2])
SITE = ROOT / "build/site"
if not shutil.which("mkdocs"):
    print("skipped: mkdocs is not installed (scripts/setup --tests)")
    sys.exit(77)
done = subprocess.run([ROOT / "scripts/docs"], capture_output=True, text=True, env={**os.environ, "PLUMBLINE": PROGRAM})
if done.returncode:
    print(done.stdout + done.stderr)
    sys.exit(1)


class Page(html.parser.HTMLParser):
    def __init__(self, file):
        super().__init__()
        self.links, self.anchors = [], set()
        self.feed(file.read_text(encoding="utf-8"))

    def handle_starttag(self, tag, attributes):
        for name, value in attributes:
            if name in ("href", "src") and value:
                self.links.append(value)
            if name in ("id", "name") and value:
                self.anchors.add(value)


pages = {file: Page(file) for file in SITE.rglob("*.html")}
faults = []
for file, page in pages.items():
    if file.name == "404.html":
        continue
    for link in page.links:
        target = urllib.parse.urlsplit(link)
        if target.scheme or target.netloc:
            if link.startswith(("http://", "https://")) and any(word in link for word in ("fonts.g", "unpkg", "jsdelivr", "cdn")):
                faults.append(f"{file}: {link} is asked from outside")
            continue
        there = (file.parent / urllib.parse.unquote(target.path)).resolve() if target.path else file
        if there.is_dir():
            there /= "index.html"
        if not there.exists():
            faults.append(f"{file.relative_to(SITE)}: {link}: there is no such file")
        elif target.fragment and there in pages and urllib.parse.unquote(target.fragment) not in pages[there].anchors:
            faults.append(f"{file.relative_to(SITE)}: {link}: there is no such anchor")
menu = (ROOT / "mkdocs.yml").read_text(encoding="utf-8")
for page in sorted(ROOT.glob("docs/**/*.md")):
    name = page.relative_to(ROOT).as_posix()
    if not (SITE / name).with_suffix(".html").exists():
        faults.append(f"{name} is not in the site")
    if f" {name}\n" not in menu:
        faults.append(f"{name} is not in the menu of mkdocs.yml")
if len(pages) < 20:
    faults.append(f"only {len(pages)} pages were made")
print(f"{len(pages)} pages, {sum(len(p.links) for p in pages.values())} links")
for fault in faults:
    print(fault)
sys.exit(1 if faults else 0)
