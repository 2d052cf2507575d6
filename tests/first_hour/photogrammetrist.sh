#!/usr/bin/env bash
# usage: photogrammetrist.sh PREFIX WORK     Photographs of tags and nothing else, then with the survey of some of them
source "$(dirname "$0")/steps.sh"
make_site
cd "$work"
cp -r made/site/images photos
step plumbline run detect_images folder=photos
says "F01-01.jpg" out/detect_images/observations.json
step plumbline run marker_board folder=photos tag_size=0.2
says "rms"
step plumbline describe photo_campaign
says "folder"
mkdir site
cp -r made/site/images made/site/control.csv made/site/survey site/
cp made/site/camera.yaml made/site/plates.csv site/
edit "campaign.yaml"
printf 'plumbline_campaign: 1\nimages: images/*.jpg\ncamera: camera.yaml\nplates: plates.csv\nsurvey: survey/*.gsi\ncontrol: control.csv\n' > site/campaign.yaml
# Photographs whose own scatter contradicts the calibration end with 3; here all is as simulated.
step plumbline run photo_campaign folder=site
test -s out/photo_campaign/report.html
took 4 1
