#!/bin/sh
# SPDX-License-Identifier: MIT
# nmea-simple 3.3.0 (npm, parser of NMEA 0183): an empty field of a number comes out as 0.
#
# What one would guess: a course that a receiver leaves empty, as it does while it stands, is null or missing, as
# gps 0.9.0 has it; so is the geoid separation that a receiver without a geoid model leaves empty.
# What it does: the course is 0 (due north), the separation 0 m, the age of corrections 0 s.
# Why it matters: a filter that takes the course for a heading is turned to the north at every stop; a height over the
# geoid that is added to a separation of 0 stands for an ellipsoidal height, wrong by up to 100 m, without a word.
# Seen on 2026-12-01:  course 0, separation 0, age 0; with fields: course 90, separation -16.9
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
npm init -y >npm.log 2>&1
npm install --no-audit --no-fund nmea-simple@3.3.0 gps@0.9.0 >>npm.log 2>&1 || { cat npm.log; exit 2; }
cat >look.js <<'JS'
const { parseNmeaSentence } = require('nmea-simple');
const GPS = require('gps');
const sentence = (body) => {
  let sum = 0;
  for (const c of body) sum ^= c.charCodeAt(0);
  return '$' + body + '*' + sum.toString(16).toUpperCase().padStart(2, '0');
};
const standing = sentence('GPRMC,173039.50,A,4006.00,N,10509.00,W,0.02,,280825,,,A');
const driving = sentence('GPRMC,173039.50,A,4006.00,N,10509.00,W,10.0,90.0,280825,,,A');
const bare = sentence('GPGGA,173039.50,4006.00,N,10509.00,W,1,12,0.8,1617.4,M,,M,,');
const full = sentence('GPGGA,173039.50,4006.00,N,10509.00,W,1,12,0.8,1617.4,M,-16.9,M,,');
const gga = parseNmeaSentence(bare);
console.log(JSON.stringify({
  standing: parseNmeaSentence(standing).trackTrue,
  driving: parseNmeaSentence(driving).trackTrue,
  separation_empty: gga.geoidalSeperation,
  separation_given: parseNmeaSentence(full).geoidalSeperation,
  age_empty: gga.differentialAge,
  other_parser: [GPS.Parse(standing).track, GPS.Parse(bare).geoidal],
}));
JS
seen=$(node look.js)
expected='{"standing":0,"driving":90,"separation_empty":0,"separation_given":-16.9,"age_empty":0,"other_parser":[null,null]}'
echo "$seen"
[ "$seen" = "$expected" ] || { echo "changed: expected $expected"; exit 1; }
