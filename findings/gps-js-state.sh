#!/bin/sh
# SPDX-License-Identifier: MIT
# gps 0.9.0 (npm, "GPS.js", parser of NMEA 0183): the state of a replayed log has a date of the day of the replay, speeds
# in km/h, and the last course of a receiver that stands.
#
# What one would guess: the time of a GGA sentence, which has no date, is a time of day or takes the date of the RMC
# before it; `speed` of RMC is in the knots that the sentence gives, or in m/s; a course that the sentence leaves empty
# leaves no course in the state.
# What it does: GGA's time is today's date at that time of day, also after an RMC of last year, so that stamps jump to and
# fro between the two days; `speed` is in km/h; `state.track` keeps the course from before the stop (the sentence's own
# `track` is null).
# Why it matters: stamps of a log that is converted by it are neither ascending nor of its day; a speed read as m/s is
# 3.6 times too large; a stale course is used as a heading while the vehicle turns on the spot.
# Seen on 2026-12-01:  the RMC's day 2025-08-28, the GGA's 2026-12-01; 10 knots are 18.52; course 90 in the state
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
npm init -y >npm.log 2>&1
npm install --no-audit --no-fund gps@0.9.0 >>npm.log 2>&1 || { cat npm.log; exit 2; }
cat >look.js <<'JS'
const GPS = require('gps');
const sentence = (body) => {
  let sum = 0;
  for (const c of body) sum ^= c.charCodeAt(0);
  return '$' + body + '*' + sum.toString(16).toUpperCase().padStart(2, '0');
};
const day = (time) => time.toISOString().slice(0, 10);
const gps = new GPS();
gps.on('data', () => {});
gps.update(sentence('GPRMC,173039.50,A,4006.00,N,10509.00,W,10.0,90.0,280825,,,A'));
const driving = { day: day(gps.state.time), speed: gps.state.speed, track: gps.state.track };
gps.update(sentence('GPGGA,173040.00,4006.00,N,10509.00,W,1,12,0.8,1617.4,M,-16.9,M,,'));
const later = day(gps.state.time) === day(new Date()) ? 'today' : day(gps.state.time);
gps.update(sentence('GPRMC,173040.50,A,4006.00,N,10509.00,W,0.02,,280825,,,A'));
console.log(JSON.stringify({ driving, day_of_gga: later, standing_track: gps.state.track }));
JS
seen=$(TZ=UTC node look.js)
expected='{"driving":{"day":"2025-08-28","speed":18.52,"track":90},"day_of_gga":"today","standing_track":90}'
echo "$seen"
[ "$seen" = "$expected" ] || { echo "changed: expected $expected"; exit 1; }
