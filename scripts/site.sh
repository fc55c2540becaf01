#!/bin/bash
# Makes a static web site of the documentation: scripts/site.sh [FOLDER], by default in build/site. May be repeated.
set -euo pipefail
cd "$(dirname "$0")/.."
. scripts/setup.sh

packages=mkdocs
install_packages
out=$(realpath -m "${1:-build/site}") stage=$(mktemp -d)
trap 'rm -rf "$stage"' EXIT
say "building the site: $out"
# mkdocs needs all pages in one folder. Links to other parts of the repository (sources, folders without a page) become plain text.
python3 - "$stage" <<'EOF'
import pathlib, re, shutil, sys
import yaml

root, pages = pathlib.Path.cwd(), pathlib.Path(sys.argv[1]) / "pages"
wanted = [p for pattern in ("*.md", "docs/**/*", "cases/*/README.md", "clients/python/README.md") for p in root.glob(pattern) if p.is_file()]
for source in wanted:
    target = pages / source.relative_to(root)
    target.parent.mkdir(parents=True, exist_ok=True)
    shutil.copy(source, target)

def link(page, words, target):
    path, mark, anchor = target.partition("#")
    if not path or "://" in path:
        return f"[{words}]({target})"
    there = page.parent / path
    if there.is_dir() and (there / "README.md").exists():
        return f"[{words}]({path.rstrip('/')}/README.md{mark}{anchor})"
    return f"[{words}]({target})" if there.is_file() else words

for page in pages.rglob("*.md"):
    text = re.sub(r"^```(\w+) .*$", r"```\1", page.read_text(), flags=re.MULTILINE)  # what follows the language is for tests
    page.write_text(re.sub(r"(?<!!)\[([^]]*)\]\(([^)\s]+)\)", lambda m: link(page, m[1], m[2]), text))

nav = [{"Home": "README.md"}]  # the pages, in the groups of docs/index.md
for line in (pages / "docs/index.md").read_text().splitlines():
    if group := re.match(r"\| \*\*(.+)\*\* \|", line):
        nav.append({group[1]: []})
    elif line.startswith("| ["):
        for words, target in re.findall(r"\[([^]]+)\]\(([^)]+)\)", line.split("|")[1]):
            path = (pages / "docs" / target).resolve().relative_to(pages.resolve()).as_posix()
            if not path.endswith(("theory/index.md", "notebook/README.md", "decisions/README.md")):
                nav[-1][next(iter(nav[-1]))].append({words: path})
                continue
            chapters = re.findall(r"\]\(([\w-]+\.md)\)", (pages / path).read_text())  # in the order of that page
            folder = path.rpartition("/")[0]
            nav[-1][next(iter(nav[-1]))].append({words: [path, *(f"{folder}/{c}" for c in dict.fromkeys(chapters) if c != "paper.md")]})
settings = {"site_name": "poretwin", "docs_dir": "pages", "theme": {"name": "mkdocs"}, "use_directory_urls": False, "nav": nav,
            "markdown_extensions": [{"toc": {"permalink": True}}, "tables", "fenced_code", "sane_lists"]}
(pages.parent / "mkdocs.yml").write_text(yaml.safe_dump(settings, sort_keys=False))
EOF
mkdocs build --quiet --clean --config-file "$stage/mkdocs.yml" --site-dir "$out"
say "open $out/index.html"
