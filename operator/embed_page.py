"""Writes the C++ source that holds the page: embed_page.py OUTPUT [FILE...]

Each file becomes gzip bytes under its name, with a strong ETag that is its SHA-256.
"""

import gzip
import hashlib
import pathlib
import sys

MIME = {".html": "text/html; charset=utf-8", ".js": "text/javascript; charset=utf-8", ".css": "text/css; charset=utf-8",
        ".svg": "image/svg+xml"}


def literal(name, data):
    rows = (data[i:i + 32] for i in range(0, len(data), 32))
    body = "\n".join(",".join(map(str, row)) + "," for row in rows)
    return f"const unsigned char {name}[] = {{\n{body}\n}};\n"


def main(output, files):
    arrays, table = [], []
    for number, path in enumerate(map(pathlib.Path, files)):
        content = path.read_bytes()
        arrays.append(literal(f"kFile{number}", gzip.compress(content, 9, mtime=0)))
        etag = hashlib.sha256(content).hexdigest()[:32]
        table.append(f'    {{"/{path.name}", "{MIME[path.suffix]}", "\\"{etag}\\"", kFile{number}}},\n')
    files_text = f"const std::array<PageFile, {len(table)}> kFiles{{{{\n{''.join(table)}}}}};\n" if table else ""
    pathlib.Path(output).write_text(
        '#include "operator/page_files.h"\n\n#include <array>\n\nnamespace headway::remote {\n\nnamespace {\n'
        + "".join(arrays) + files_text + "}  // namespace\n\nstd::span<const PageFile> page_files() { return "
        + ("kFiles" if table else "{}") + "; }\n\n}  // namespace headway::remote\n")


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2:])
