#!/usr/bin/env bash
# usage: surveyor.sh PREFIX WORK     From an instrument's file to coordinates with a verdict; then a second day, and what has moved
source "$(dirname "$0")/steps.sh"
make_site
cd "$work"
cp made/site/survey/total_station.gsi monday.gsi
step plumbline run survey_network file=monday.gsi
says "Sound: "
grep -q 'F01-C01-R1' out/survey_network/coordinates.csv
test -s out/survey_network/network.html
step plumbline show out/survey_network --relative F01-C01-R1 F01-C03-R1
says "mm"
# A line that was cut on the way is named, and not passed over.
head -c 3000 monday.gsi > cut.gsi
fails plumbline run survey_network file=cut.gsi
says "cut.gsi:"
# The same network measured again: distances off by less than 0.1 mm.
sed -E 's/(31\.\.08\+[0-9]{15})[0-9] /\19 /' monday.gsi > tuesday.gsi
step plumbline run compare_epochs before=monday.gsi after=tuesday.gsi
test -s out/compare_epochs/movements.html
# A table without units is a question, not a guess.
printf 'station,target,hz,v,sd\nS1,A,0.0,90.0,10.0\nS1,B,45.0,89.0,12.0\nS1,C,90.0,91.0,12.0\n' > table.csv
fails plumbline run survey_network file=table.csv
says "found angles without a unit"
took 5 0
