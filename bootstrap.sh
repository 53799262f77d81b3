#!/bin/sh
# Installs the Debian packages of apt-packages.txt that are missing; does nothing (in milliseconds) where all are there.
set -eu
cd "$(dirname "$0")"
missing=
for package in $(grep -v '^#' apt-packages.txt); do
  [ "$(dpkg-query -W -f='${db:Status-Abbrev}' "$package" 2>/dev/null)" = 'ii ' ] || missing="$missing $package"
done
[ -n "$missing" ] || exit 0
echo "bootstrap: installing$missing" >&2
root=
if [ "$(id -u)" != 0 ]; then
  command -v sudo >/dev/null || { echo "bootstrap: not root and no sudo; install these yourself:$missing" >&2; exit 1; }
  root=sudo
fi
$root apt-get update -qq
# shellcheck disable=SC2086 # one word per package is what is meant
$root env DEBIAN_FRONTEND=noninteractive apt-get install -qq -y --no-install-recommends $missing >/dev/null
