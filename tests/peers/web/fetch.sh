#!/bin/sh
# SPDX-License-Identifier: MIT
# Fetches the libraries of the web in their pinned versions into build/web, and makes a page of each. Needs npm and a
# network; nothing else of isoshade does.
set -eu
cd "$(dirname "$0")"
web=../../../build/web
mkdir -p "$web"
cp package.json package-lock.json .npmrc page*.js "$web"
cd "$web"
npm ci --loglevel=error
for library in vtkjs niivue; do
    node_modules/.bin/esbuild "page_$library.js" --bundle --minify --format=iife --log-level=error \
        --outfile="$library.js"
    printf '<!doctype html><meta charset="utf-8"><body style="margin:0"><script src="%s.js"></script></body>\n' \
        "$library" >"$library.html"
done
echo "The pages are in $PWD"
