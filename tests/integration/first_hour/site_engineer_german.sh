#!/usr/bin/env bash
# usage: site_engineer_german.sh PLUMBLINE WORK     A German folder: Excel's tables, two cameras, umlauts, a protocol, no campaign.yaml
source "$(dirname "$0")/steps.sh"
cd "$work"
# The site itself: simulated photographs, re-made as somebody in an office would hand them over.
cat > make.yaml <<'YAML'
plumbline: 1
vars: {seed: 2}
nodes:
  site: {use: simulate.campaign, with: {floors: 1, columns: 3, camera: quick_6mp, images_per_floor: 6}}
outputs: {site: site.folder}
YAML
plumbline run make.yaml --out made -q
mkdir -p "Turm Süd/Fotos/Kran" "Turm Süd/Fotos/Boden" "Turm Süd/Vermessung"
site="$work/Turm Süd"
cp made/site/images/F01-0[123].jpg "$site/Fotos/Kran/"
cp made/site/images/F01-0[456].jpg "$site/Fotos/Boden/"
cp made/site/survey/total_station.gsi "$site/Vermessung/Montag Süd.gsi"
cp made/site/design.ifc "$site/Entwurf Süd.ifc"
cp made/site/camera.yaml "$site/Kamera.yaml"
sed -e 's/,/;/g' -e 's/^anchor;role;floor;column;row;tag_family;tag_id;tag_size_mm/Anker;Rolle;Geschoss;Spalte;Zeile;Tag-Familie;Tag-Nr;Tag-Größe [mm]/' \
  -e 's/;control;/;Passpunkt;/; s/;check;/;Kontrollpunkt;/' -e '1s/$/;Bemerkung;;/; 1!s/$/;neu gedübelt;;/' -e 's/$/\r/' made/site/plates.csv > "$site/Schilder.csv"
printf ';;;;;;;;;;;;;;\r\n' >> "$site/Schilder.csv"
sed -e 's/,/;/g' -e 's/\./,/g' made/site/control.csv > "$site/Festpunkte.csv"
printf 'PK' > "$site/Protokoll.docx"
printf '\0\5' > "$site/Fotos/Kran/._F01-01.jpg"
printf 'x' > "$site/Fotos/Thumbs.db"

step plumbline campaign init "$site" | tee .said
says "Recognised:"
step plumbline campaign check "$site" | tee .said
says "The folder is whole."
says "Took part: 6 photographs"
cd "$site"
step plumbline run site_campaign folder=. | tee "$work/.said"
says "Took part: 6 photographs"
says "In the folder and not read:"
says "Protokoll.docx"
# Next day: a second survey file that nobody names is not passed over.
cp "Vermessung/Montag Süd.gsi" Vermessung/Dienstag.gsi
fails plumbline run site_campaign folder=.
says "1 survey file (Vermessung/Dienstag.gsi) that nothing names"
edit "unused: Vermessung/Dienstag.gsi"
echo "unused: Vermessung/Dienstag.gsi" >> campaign.yaml
step plumbline run site_campaign folder=. | tee "$work/.said"
says "Set aside by 'unused': Vermessung/Dienstag.gsi"
took 5 1
