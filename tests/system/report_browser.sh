#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# report_browser.sh MAKE_SYNTHETIC_RESULTS | report_browser.sh RESULTS...
# Loads report pages in headless Chromium: no console error, no request to anywhere, and every figure drawn (the page checks itself and
# writes its finding into <body data-figures>). Without Chromium it is skipped, loudly (exit 77).
set -u
browser=$(command -v chromium || command -v chromium-browser || command -v google-chrome || true)
if [ -z "$browser" ]; then
  echo "SKIPPED: no Chromium on this machine; the report page was not looked at in a browser (Debian: apt-get install chromium)" >&2
  exit 77
fi
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
failures=0

# load PAGE -> $work/dom.html, $work/log.txt
load() {
  timeout 120 "$browser" --headless --no-sandbox --disable-gpu --disable-background-networking --no-first-run --user-data-dir="$work/profile" \
    --window-size=1280,900 --enable-logging=stderr --v=0 --virtual-time-budget=20000 --dump-dom "file://$1" > "$work/dom.html" 2> "$work/log.txt"
}

# check PAGE FIGURES: the page must be clean and hold that many figures (0: at least one)
check() {
  load "$1" || { echo "FAILED: $1: Chromium ended with an error or took too long" >&2; tail -5 "$work/log.txt" >&2; failures=$((failures + 1)); return; }
  local found count
  # on a busy machine Chromium's virtual time may run out before the page's script has had its turn: that alone is tried again
  for attempt in 2 3; do
    grep -q '<body[^>]*data-figures=' "$work/dom.html" && break
    echo "note: $1: the page had not finished, attempt $attempt" >&2
    load "$1"
  done
  found=$(grep -o '<body[^>]*data-figures="[^"]*"' "$work/dom.html" | sed 's/.*data-figures="//; s/"$//')
  count=$(grep -o '<body[^>]*data-count="[^"]*"' "$work/dom.html" | sed 's/.*data-count="//; s/"$//')
  if grep -q 'CONSOLE' "$work/log.txt"; then
    echo "FAILED: $1: the page wrote to the console:" >&2
    grep 'CONSOLE' "$work/log.txt" >&2
    failures=$((failures + 1))
  elif [ "$found" != ok ]; then
    echo "FAILED: $1: figures: ${found:-the page did not finish}" >&2
    failures=$((failures + 1))
  elif { [ "$2" -gt 0 ] && [ "$count" != "$2" ]; } || [ "${count:-0}" -lt 1 ]; then
    echo "FAILED: $1: $count figures, expected $2" >&2
    failures=$((failures + 1))
  else
    echo "ok: $1: $count figures with content"
  fi
}

if [ $# -eq 1 ] && [ -x "$1" ] && [ ! -d "$1" ]; then
  "$1" "$work/sealed" > /dev/null || exit 1
  "$1" "$work/leaking" --leaking > /dev/null || exit 1
  "$1" "$work/dry" --dry --no-chordae > /dev/null || exit 1
  check "$work/sealed/report.html" 7
  check "$work/leaking/report.html" 7
  check "$work/dry/report.html" 5
  # the check itself must be able to fail: a page whose data lost a figure, and one with an error in its script
  sed 's/"pressure":\[\[/"pressures":[[/' "$work/sealed/report.html" > "$work/broken.html"
  sed 's|<script type="application/json" id="data">|<script>undefined_function();</script>&|' "$work/sealed/report.html" > "$work/noisy.html"
  for page in broken noisy; do
    before=$failures
    check "$work/$page.html" 7 2> "$work/expected.txt"
    if [ "$failures" -eq "$before" ]; then
      echo "FAILED: the $page page was not noticed" >&2
      failures=$((failures + 1))
    else
      failures=$before
      echo "ok: the $page page is noticed"
    fi
  done
else
  for results in "$@"; do check "$(realpath "$results")/report.html" 0; done
fi
[ "$failures" -eq 0 ]
