// SPDX-License-Identifier: MIT
// Draws closed-loop flights from the JSON in #data (flight_data in flight_json.cpp), with plot.js.
"use strict";
