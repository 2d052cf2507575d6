#!/usr/bin/env bash
# usage: site_engineer_german.sh PREFIX WORK     A German folder: Excel's tables, two cameras of one model, umlauts, a protocol, what
#                                                Macs and Windows leave, a plate that is gone, no campaign.yaml
here=$(cd "$(dirname "$0")" && pwd)
source "$here/steps.sh"
make_site ", lost_plates: 0.1"
site="$work/Turm Süd"
mkdir -p "$site/Fotos/Kran" "$site/Fotos/Boden" "$site/Vermessung"
cd "$work/made/site"
cp images/F01-0[123].jpg "$site/Fotos/Kran/"
cp images/F01-0[456].jpg "$site/Fotos/Boden/"
mv "$site/Fotos/Boden/F01-06.jpg" "$site/Fotos/Boden/F01-06.JPG"
cp survey/total_station.gsi "$site/Vermessung/Montag Süd.gsi"
cp design.ifc "$site/Entwurf Süd.ifc"
sed 's/^id: .*/id: kran/' camera.yaml > "$site/Kamera Kran.yaml"
sed 's/^id: .*/id: boden/' camera.yaml > "$site/Kamera Boden.yaml"
sed -e 's/,/;/g' -e 's/^anchor;role;floor;column;row;tag_family;tag_id;tag_size_mm/Anker;Rolle;Geschoss;Spalte;Zeile;Tag-Familie;Tag-Nr;Tag-Größe [mm]/' \
  -e 's/;control;/;Passpunkt;/; s/;check;/;Kontrollpunkt;/' -e '1s/$/;Bemerkung;;/; 1!s/$/;neu gedübelt;;/' -e 's/$/\r/' plates.csv > "$site/Schilder.csv"
printf ';;;;;;;;;;;;;;\r\n' >> "$site/Schilder.csv"
sed -e 's/,/;/g' -e 's/\./,/g' control.csv > "$work/Festpunkte.csv"
# One table as Excel's CSV, one in its own format, with a title above.
{ printf 'Projekt Turm Süd;;\n\n'; cat "$work/Festpunkte.csv"; } > "$work/Blatt.csv"
python3 "$here/workbook.py" "$work/Blatt.csv" "$site/Festpunkte.xlsx"
printf 'PK' > "$site/Protokoll.docx"
printf '\0\5' > "$site/Fotos/Kran/._F01-01.jpg"
printf 'x' > "$site/Fotos/Thumbs.db"
printf 'x' > "$site/"$'Skizze\033[2J.txt'   # what would clear the screen
cd "$work"

step plumbline campaign init "$site"
says 'Kamera Kran.yaml'
says 'control: Festpunkte.xlsx'
step plumbline campaign check "$site"
says "The folder is whole."
says "Took part: 6 photographs"
says 'Skizze\x1b[2J.txt'
cd "$site"
step plumbline run site_campaign folder=.
says "Took part: 6 photographs"
says "In the folder and not read:"
says "Protokoll.docx"
grep -qi 'not measured' out/site_campaign/report.html   # the plate that is gone is told, not left out
grep -q 'boden' out/site_campaign/report.html
took 3 0

# Next day: a second survey file that nobody names is not passed over.
cp "Vermessung/Montag Süd.gsi" Vermessung/Dienstag.gsi
fails plumbline run site_campaign folder=.
says "1 survey file (Vermessung/Dienstag.gsi) that nothing names"
edit "unused: Vermessung/Dienstag.gsi"
echo "unused: Vermessung/Dienstag.gsi" >> campaign.yaml
step plumbline run site_campaign folder=.
says "Set aside by 'unused': Vermessung/Dienstag.gsi"
took 5 1
