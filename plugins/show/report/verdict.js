// The rule of the program at another tolerance, as verdict_at() of libraries/building/judgement/conformance.hpp has it; a test compares them.
"use strict";
// given: the verdict in force (0 not measured, 1 pass, 2 undecided, 3 fail). turning: [m] pass from, fail below; null where nobody
// knows, 1e300 for infinity. tolerance: [mm]. doubt: a measurement that contradicts itself lets nothing pass, at any tolerance.
const verdictAt = (given, [pass, fail], tolerance, doubt) => {
  const metres = tolerance / 1e3;
  if (given === 0) return 0;
  if (pass !== null && metres >= pass) return doubt ? 2 : 1;
  return fail !== null && metres < fail ? 3 : 2;
};
