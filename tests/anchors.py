# SPDX-License-Identifier: MIT
# anchors.py FOLDER: a line for each link of its Markdown pages whose #part is no heading of the page that it leads to.
import os, re, sys

def pages():
    for folder, folders, files in os.walk('.'):
        folders[:] = ['doc'] if folder == '.' else folders
        yield from (os.path.normpath(os.path.join(folder, name)) for name in files if name.endswith('.md'))

def lines(page):  # numbered, without those of code
    code = False
    for number, line in enumerate(open(page), 1):
        code ^= line.startswith('```')
        if not code and not line.startswith('    '):
            yield number, line

def headings(page):  # as GitHub makes anchors of them
    for _, line in lines(page):
        if line.startswith('#'):
            text = re.sub(r'\[([^]]*)\]\([^)]*\)', r'\1', line.lstrip('#').strip().lower())
            yield re.sub(r'[^\w\- ]', '', text).replace(' ', '-')

os.chdir(sys.argv[1])
known = {page: set(headings(page)) for page in pages()}
for page in sorted(known):
    for number, line in lines(page):
        for path, part in re.findall(r'\]\(([^)#:\s]*)#([^)\s]+)\)', line):
            target = os.path.normpath(os.path.join(os.path.dirname(page), path)) if path else page
            if part not in known.get(target, ()):
                print(f'{page}:{number} links to {target}#{part}, which is no heading there')
