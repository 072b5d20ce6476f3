#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Starts the command with the libraries beside it, wherever its folder stands.
needed=@GLIBC@
found=$(getconf GNU_LIBC_VERSION 2>/dev/null)
found=${found#glibc }
if [ "$(printf '%s\n' "$needed" "${found:-0}" | sort -V | head -n 1)" != "$needed" ]; then
  echo "kalfem: this program needs the C library glibc $needed or later, and this system has ${found:-another one}: build kalfem here, by scripts/build" >&2
  exit 1
fi
exec "$(dirname "$(readlink -f "$0")")/../lib/kalfem/kalfem" "$@"
