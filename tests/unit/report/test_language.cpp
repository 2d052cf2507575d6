// Pages and summary in German: no text without its German, no English word on a German page, no name taken for a word.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <regex>
#include <set>

#include "example.hpp"
#include "show/report/catalogue.hpp"
#include "show/report/language.hpp"
#include "show/report/script_data.hpp"
#include "show/report/sheets_page.hpp"
#include "show/report/summary.hpp"
#include "show/report/surface_page.hpp"
#include "source_texts.hpp"
#include "spoken_pages.hpp"
#include "test_support.hpp"

namespace plumbline::report {
namespace test_language {

using test::full_example;
using test::numbers_of;
using test::texts_read;

constexpr Speech kGerman{Language::german, Units::millimetres};

TEST(Catalogue, PutsPlacesWhereTheOtherLanguageHasThem) {
  const Catalogue catalogue(
      "# a comment\n\nAnchor {id} is {#x} mm {~way}.\n  {~way} liegt Anker {id} um {#x} mm.\ntoo low\n  Zu tief\n"
      "{#n} anchor\n  {#n} Anker\n{~a} is out\n  {~a} außerhalb\n"
      "Camera: {name}.\n  Kamera: {name}.\nDate: {day}.\n  Tag: {day}.\n",
      ',');
  EXPECT_EQ(catalogue.find("Anchor F1.2 is −3.5 mm too low."), "Zu tief liegt Anker F1.2 um −3,5 mm.");
  EXPECT_EQ(catalogue.find("Anchor A is 3.5\u00A0mm too low."), "Zu tief liegt Anker A um 3,5 mm.")
      << "a no-break space is one";
  EXPECT_EQ(catalogue.find("Anchor A is far mm too low."), std::nullopt) << "a number is asked for";
  EXPECT_EQ(catalogue.find("1 anchor, 2 anchor and too low is out"), "1 Anker, 2 Anker und Zu tief außerhalb")
      << "a list";
  EXPECT_EQ(catalogue.find("too low. Anchor A is 3.5 mm too low. 2 anchor."),
            "Zu tief. Zu tief liegt Anker A um 3,5 mm. 2 Anker.")
      << "sentences one after another";
  EXPECT_EQ(catalogue.find("Camera: A. Date: B."), "Kamera: A. Tag: B.")
      << "no place reaches over the end of a sentence";
  EXPECT_EQ(catalogue.find("1.5.0 anchor"), std::nullopt) << "a version is no number";
  EXPECT_EQ(catalogue.find("something else"), std::nullopt);
  EXPECT_EQ(catalogue.find("too low. something else."), std::nullopt) << "nothing half and half";
}

/// Each point of a list has its own numbers; they kept the decimal point. Levels have heights alone.
TEST(Catalogue, ListsOfKnownPointsHaveTheLanguagesDecimalSign) {
  EXPECT_EQ(
      german().find("2 known points, as measured minus as known: G1 E +1.2, N -0.3, H +2.1 mm; G2 E -1.0, N +0.4, "
                    "H +0.1 mm."),
      "2 bekannte Punkte, gemessen minus bekannt: G1 E +1,2, N -0,3, H +2,1 mm; G2 E -1,0, N +0,4, H +0,1 mm.")
      << "with the full stop of a line, all before the last point was taken for its name";
  EXPECT_EQ(
      german().find("3 known points, as measured minus as known: P1.1 E +1.2, N -0.3, H +2.1 mm; P2 E -1.0, N +0.4 mm; "
                    "P3 H -2.5 mm"),
      "3 bekannte Punkte, gemessen minus bekannt: P1.1 E +1,2, N -0,3, H +2,1 mm; P2 E -1,0, N +0,4 mm; P3 H -2,5 mm");
  const std::string doubtful = german()
                                   .find(
                                       "6 known points, as measured minus as known: A E +1.2, N -0.3, H +2.1 mm; B E "
                                       "-1.0, N +0.4, H +0.1 mm; 4 less. They do not "
                                       "fit each other and the readings: one of them is wrong or has moved, or a "
                                       "reading between them; if they are only less good than that, give their "
                                       "standard deviations (keyed in: known_sigma)")
                                   .value_or("");
  EXPECT_TRUE(
      doubtful.starts_with("6 bekannte Punkte, gemessen minus bekannt: A E +1,2, N -0,3, H +2,1 mm; B E -1,0, N +0,4, "
                           "H +0,1 mm; 4 weniger. "))
      << doubtful;
  EXPECT_EQ(german().find("1 known point, as measured minus as known: HP4 H +0.7 mm"),
            "1 bekannter Punkt, gemessen minus bekannt: HP4 H +0,7 mm");
}

/// "{bracket} {#limit} mm {~direction}" is one end of a range, and not the first two of three lengths.
TEST(Catalogue, NoNameEndsInAComma) {
  EXPECT_EQ(german().find("Reset or shim: 7.5 mm outward, 6.6 mm to the right, 6.2 mm down."),
            "Versetzen oder unterlegen: 7,5 mm nach außen, 6,6 mm nach rechts, 6,2 mm nach unten.");
}

/// What is said of photographs, whose words are no text of the report's sources.
TEST(German, HasTheSizesOfPhotographs) {
  const auto said = german().find(
      "the photographs come in several sizes (17 of 640 x 480 pixels; 16 of 1280 x 720 pixels): some were resized, "
      "cropped or turned by a program, or taken with another setting or by another camera. Each size is calibrated as "
      "a "
      "camera of its own, from its photographs alone: if it is one camera, use the files as it wrote them");
  ASSERT_TRUE(said);
  EXPECT_TRUE(said->starts_with("Die Fotos haben mehrere Größen (17 mit 640 x 480 Pixeln; 16 mit 1280 x 720 Pixeln): "))
      << *said;
}

/// The first line of a survey that has a mistake of the field: its words are no text of the report's sources.
TEST(German, NamesTheMistakeThatExplainsASurvey) {
  const std::string adjusted =
      ". Adjusted with that undone, sigma0 is 0.97 in place of 612.30. Mend it in the file: nothing was changed here";
  const auto said = [&](const std::string& cause) {
    return german().find("probably: " + cause + adjusted).value_or("");
  };
  const std::string so =
      ". Ohne das ausgeglichen ist sigma0 0,97 statt 612,30. In der Datei berichtigen: hier wurde nichts geändert";
  EXPECT_EQ(said("the zenith angles of set-up S3 are counted from the horizon: so 98 % of the sights to common points "
                 "agree, as they are, 12 %"),
            "wahrscheinlich: die Zenitwinkel von Aufstellung S3 sind vom Horizont aus gezählt: so stimmen 98 % der "
            "Zielungen nach gemeinsamen Punkten überein, so wie sie sind 12 %" +
                so);
  EXPECT_EQ(said("of the known points M22, M8 E and N are exchanged (the other 3 agree with the readings)"),
            "wahrscheinlich: bei den bekannten Punkten M22, M8 sind E und N vertauscht (die anderen 3 passen zu den "
            "Ablesungen)" +
                so);
  EXPECT_EQ(
      said("the known points M22 and M8 have each other's coordinates: so all 5 lie where the readings see them, as "
           "they are, 3"),
      "wahrscheinlich: die bekannten Punkte M22 und M8 haben die Koordinaten voneinander: so liegen alle 5, wo die "
      "Ablesungen sie sehen, so wie sie sind 3" +
          so);
}

/// What a control point of targets is used as.
TEST(German, WhatTenKelvinDoAndReportsThatWereNotTaken) {
  const Speaking german(speech_of("de", "mm"));
  const auto said = [](const std::string& english) {
    std::string text = spoken(english);
    for (std::size_t at = 0; (at = text.find("\u00A0", at)) != std::string::npos;) text.replace(at, 2, " ");
    return text;
  };
  EXPECT_EQ(
      said("The model knows no temperature: 10 K make the 60.0 m of height between these anchors 6.0 mm longer or "
           "shorter, and their 30.0 m of width 3.0 mm (concrete, 1e-5 a kelvin by EN 1991-1-5); the smallest "
           "tolerance is 5.0 mm; the median standard deviation of a height is 0.40 mm"),
      "Das Modell kennt keine Temperatur: 10 K machen die 60,0 m Höhe zwischen diesen Ankern um 6,0 mm länger "
      "oder kürzer, und ihre 30,0 m Breite um 3,0 mm (Beton, 1e-5 je Kelvin nach EN 1991-1-5); die kleinste "
      "Toleranz ist 5,0 mm; der Median der Standardabweichungen der Höhen ist 0,40 mm");
  EXPECT_EQ(said("report on F01-C01-R1 by robot-1 (a.json: items[4])"),
            "Bericht über F01-C01-R1 von robot-1 (a.json: items[4])");
  EXPECT_EQ(said("no bracket or panel of this name is known; but for case, separators or leading zeros it is B2"),
            "keine Konsole und kein Paneel dieses Namens ist bekannt; bis auf Groß- und Kleinschreibung, Trennzeichen "
            "oder führende Nullen ist es B2");
  EXPECT_EQ(said("its 2 anchors are in one line: how it is turned about that is not known, nor how far its corners are "
                 "out; where the panel below or a sill holds its bottom edge, held_below says so"),
            "seine 2 Anker liegen in einer Linie: wie es um sie gedreht ist, ist nicht bekannt, auch nicht, wie weit "
            "seine Ecken außen stehen; wo das Paneel darunter oder eine Schwelle seine Unterkante hält, sagt das "
            "held_below");
}

TEST(Catalogue, UsesOfControlPoints) {
  EXPECT_EQ(german().find("control, weighted"), "Passpunkt, gewichtet");
  EXPECT_EQ(german().find("control, fixed"), "Passpunkt, festgehalten");
  EXPECT_EQ(german().find("control, set aside"), "Passpunkt, nicht verwendet");
}

/// "{id}: {~note}" took "p 0.067; corner bottom left of F01-P01, right" for a name, and all of it stayed English.
TEST(Catalogue, AReasonThatBeginsWithItsProbabilityIsAListOfReasons) {
  const std::string reason =
      "p 0.067; corner bottom left of F01-P01, right: 0.2 mm, limits -5.0 and 5.0 mm, u 9.44 mm; no single measurement "
      "decides it; a robot that sets to 0.97 mm would do";
  const std::string german_reason =
      "p 0,067; Ecke unten links von F01-P01, rechts: 0,2 mm, Grenzen -5,0 und 5,0 mm, u 9,44 mm; keine einzelne "
      "Messung entscheidet es; ein Roboter, der auf 0,97 mm setzt, w\u00FCrde gen\u00FCgen";
  EXPECT_EQ(german().find(reason), german_reason);
  EXPECT_EQ(german().find("F01-P01: " + reason), "F01-P01: " + german_reason);
}

/// Two quantities of one rule of surfaces: the second stayed English, as the first's place reached to the last bracket.
TEST(Catalogue, NoPlaceReachesOutOfItsBrackets) {
  EXPECT_EQ(german().find("flatness(2m): 2 of 3 are not judged: P1, P2 (the first: no face of it was looked at); "
                          "step: 1 of 2 are not judged: P3 (no face of it was looked at)"),
            "Ebenheit(2m): 2 von 3 sind nicht beurteilt: P1, P2 (beim ersten: keine Fläche davon wurde betrachtet); "
            "Versprung: 1 von 2 sind nicht beurteilt: P3 (keine Fläche davon wurde betrachtet)");
}

/// The second sentence alone looked like "Measure {anchor}.", and the first stayed English.
TEST(Catalogue, ANoteOfTwoSentencesIsOne) {
  EXPECT_TRUE(
      german()
          .find("Note: The anchors were measured by total station alone: nothing here is evidence of its accuracy "
                "but the network's own redundancy. Measure some anchors again from other set-ups, or in "
                "photographs.")
          .value_or("")
          .starts_with("Hinweis: Die Anker"));
}

TEST(Catalogue, ListsThatWereCutEndInTheOtherLanguage) {
  EXPECT_EQ(german().find("No photograph at hand shows the marker of F01-K1, F01-K2 and 43 more."),
            "Kein vorliegendes Foto zeigt die Marke von F01-K1, F01-K2 und 43 weitere.");
}

TEST(Catalogue, RefusesWithTheLine) {
  const auto error = [](const std::string& text) {
    try {
      const Catalogue catalogue(text, ',');
    } catch (const std::runtime_error& failure) {
      return std::string(failure.what());
    }
    return std::string("taken");
  };
  EXPECT_NE(error("a\n  b\na\n  c\n").find("line 3"), std::string::npos) << "twice";
  EXPECT_NE(error("a {x}\n  b {y}\n").find("same places"), std::string::npos);
  EXPECT_NE(error("a\nb\n  c\n").find("nothing in the other language"), std::string::npos);
  EXPECT_NE(error("a\n").find("nothing in the other language"), std::string::npos);
  EXPECT_NE(error("{a}{b}\n  {b} {a}\n").find("between them"), std::string::npos);
  EXPECT_NE(error("a {#x} of {x}\n  b {#x} {x}\n").find("one name"), std::string::npos);
  EXPECT_EQ(error("a {x}\n  b {x}\n"), "taken");
}

/// Every text that sections of the page, the summary or the judgement compose is part of a sentence that has its
/// German.
TEST(German, HasEveryTextOfTheSources) {
  std::string sentences;
  for (const auto& entry : german().entries()) sentences += entry.written + "\n";
  const std::filesystem::path root = plumbline::test::source_dir();
  for (const std::string& file : test::files_with_texts(root))
    for (const test::SourceText& text : test::texts_of(root / file))
      for (const std::string& words : test::words_between_places(text.text))
        EXPECT_NE(sentences.find(words), std::string::npos)
            << file << ":" << text.line << ": '" << words << "' is in no sentence of plugins/show/report/german.txt";
}

/// What page.js and view.js say, too: tell("…") of what script_texts() hands to them.
TEST(German, HasEveryTextOfTheScripts) {
  std::set<std::string> handed(script_texts().begin(), script_texts().end());
  for (const std::string& text : handed) EXPECT_TRUE(german().find(text).has_value()) << text;
  for (const char* script : {"page.js", "view.js"}) {
    const std::string source = plumbline::test::read_file(std::filesystem::path(plumbline::test::source_dir()) /
                                                          "plugins/show/report" / script);
    const std::regex told("tell\\(\"([^\"]*)\"");
    for (std::sregex_iterator at(source.begin(), source.end(), told), end; at != end; ++at) {
      const std::string text = std::regex_replace((*at)[1].str(), std::regex("\\\\u03b7"), "\u03b7");
      EXPECT_TRUE(handed.contains(text)) << script << " says '" << text << "'";
    }
  }
}

std::set<std::string> words_in(const std::string& text) {
  std::set<std::string> words;
  std::string word;
  for (const char c : text + " ") {
    const auto byte = static_cast<unsigned char>(c);
    if (std::isalpha(byte) != 0 || byte >= 0xC3)
      word += static_cast<char>(std::tolower(byte));
    else if (byte >= 0x80 && !word.empty())
      word += c;
    else {
      if (word.size() > 1) words.insert(word);
      word.clear();
    }
  }
  return words;
}

/// Words of the catalogue's English that its German does not have.
const std::set<std::string>& english_words() {
  static const std::set<std::string> words = [] {
    std::set<std::string> english, other;
    for (const auto& entry : german().entries()) {
      for (const auto& part : entry.english)
        if (part.kind == Catalogue::Part::Kind::words) english.merge(words_in(part.text));
      for (const auto& part : entry.other)
        if (part.kind == Catalogue::Part::Kind::words) other.merge(words_in(part.text));
    }
    for (const std::string& word : other) english.erase(word);
    return english;
  }();
  return words;
}

/// Texts with an English word once what was given is taken out of them.
std::vector<std::string> english_in(const std::vector<std::string>& texts, const std::vector<std::string>& given) {
  std::vector<std::string> found;
  for (std::string text : texts) {
    const std::string whole = text;
    for (const std::string& name : given)
      for (std::size_t at = 0; (at = text.find(name, at)) != std::string::npos;) text.erase(at, name.size());
    for (const std::string& word : words_in(text))
      if (english_words().contains(word)) {
        found.push_back(word + ": " + whole);
        break;
      }
  }
  return found;
}

const std::vector<std::string> kGiven = {"Facade anchors, full height",
                                         "Example building, south facade, 5 floors. Campaign of 12 May 2025",
                                         "Points F05-C01-R1 and F05-C02-R1 are seen from two set-ups only.",
                                         "full_height",
                                         "REASON",
                                         "name~^C-: azimuth=135deg",
                                         "Level ",
                                         "campaign.yaml",
                                         "observations.csv",
                                         "survey/station1.gsi",
                                         "station1.gsi",
                                         "station2.gsi",
                                         "station3.gsi",
                                         "station4.gsi",
                                         "60303ae22b998861bce3b28f33eec1be758a213c86c93c076dbe9f558c11c752",
                                         "survey/station1.gsi",
                                         "class=IfcPlat: vertical=5mm",
                                         "guid of ",
                                         "panel0",
                                         "panel1",
                                         "panel2",
                                         "panel3"};

TEST(German, NoEnglishWordIsLeftOnAPage) {
  const Speaking speaking(kGerman);
  const ReportInput input = full_example();
  for (const std::string& text : english_in(texts_read(render_report(input)), kGiven))
    ADD_FAILURE() << "report: " << text;
  for (const std::string& text : english_in(texts_read(render_sheets(input)), kGiven))
    ADD_FAILURE() << "sheets: " << text;
  ReportInput quiet = test::example();  // without a design: the pages of what was measured alone
  quiet.deviation.reset();
  for (const std::string& text : english_in(texts_read(render_report(quiet)), kGiven))
    ADD_FAILURE() << "report: " << text;
}

TEST(German, NoEnglishWordIsLeftOnThePageOfSurfaces) {
  const Speaking speaking(kGerman);
  SurfacesT surfaces;
  for (const char* name : {"P1", "P2"}) {
    auto panel = std::make_unique<PanelSurfaceFiguresT>();
    panel->face = std::make_unique<SurfaceFaceT>();
    SurfaceFaceT& face = *panel->face;
    face.id = name, face.out = {0, -1, 0}, face.up = {0, 0, 1}, face.right = {1, 0, 0}, face.origin.setZero();
    face.width = 1, face.height = 2, panel->offset = 0.004, panel->coefficients = {0.004, 0, 0, 0, 0, 0};
    surfaces.panels.push_back(std::move(panel));
  }
  auto joint = std::make_unique<JointFiguresT>();
  joint->first = "P1", joint->second = "P2", joint->nominal_width = 0.012, joint->looked_at = 9;
  joint->not_measured = "one of its panels was not measured";
  surfaces.joints.push_back(std::move(joint));
  SurfaceJudgementT judgement;
  for (const char* quantity : {"flatness", "bow", "step", "joint", "narrowest"}) {
    auto verdict = std::make_unique<SurfaceVerdictT>();
    verdict->quantity = quantity, verdict->panel = "P1", verdict->rule = "*: bow=3mm", verdict->value = 0.0042;
    verdict->sigma = 0.0003, verdict->upper = 0.003, verdict->lower = -0.003;
    verdict->verdict = ToleranceVerdict::fail;
    judgement.verdicts.push_back(std::move(verdict));
  }
  judgement.verdicts.front()->length = 1;
  judgement.verdicts.back()->not_judged = "no face of it was looked at";
  const auto texts = texts_read(render_surface_page(surfaces, &judgement, "Surfaces of panels and joints"));
  for (const std::string& text : english_in(texts, {"*: bow=3mm"})) ADD_FAILURE() << text;
}

/// No sentence loses a number, tells one twice or changes one.
TEST(German, EverySentenceHasTheNumbersOfTheEnglishOne) {
  const ReportInput input = full_example();
  const auto sorted = [](std::string text, bool comma) {
    if (comma) text = std::regex_replace(text, std::regex("(\\d),(\\d)"), "$1.$2");
    std::vector<std::string> numbers = numbers_of(text);
    std::sort(numbers.begin(), numbers.end());
    return numbers;
  };
  const auto page = texts_read(render_report(input)), sheets = texts_read(render_sheets(input));
  const Speaking speaking(kGerman);
  for (const auto& [english, other] :
       {std::pair(page, texts_read(render_report(input))), std::pair(sheets, texts_read(render_sheets(input)))}) {
    ASSERT_LE(english.size(), other.size());
    int numbers = 0;
    for (std::size_t i = 0; i < english.size(); ++i) {
      EXPECT_EQ(sorted(english[i], false), sorted(other[i], true)) << english[i] << " | " << other[i];
      numbers += static_cast<int>(numbers_of(english[i]).size());
    }
    EXPECT_GT(numbers, 100);
  }
}

/// Every sentence of the catalogue with places, filled in: it is found as itself and not as a part of another one, its
/// places stand where the German has them, and its numbers are the same with a comma.
TEST(German, EverySentenceOfTheCatalogueIsFoundWithItsPlacesAndNumbers) {
  using Kind = Catalogue::Part::Kind;
  int with_places = 0;
  for (const Catalogue::Entry& entry : german().entries()) {
    std::map<std::string, std::string> filled;
    std::string said, expected;
    for (const auto& part : entry.english) {
      if (part.kind == Kind::words) {
        said += part.text;
        continue;
      }
      const std::string n = std::to_string(filled.size() + 1);
      filled[part.text] = part.kind == Kind::number ? n + n + "." + n + "5" : "Xq" + n;
      said += filled[part.text];
    }
    if (filled.empty()) continue;
    ++with_places;
    for (const auto& part : entry.other) {
      if (part.kind == Kind::words)
        expected += part.text;
      else
        expected += part.kind == Kind::number ? german().number(filled[part.text]) : filled[part.text];
    }
    EXPECT_EQ(german().find(said).value_or("nothing"), expected) << entry.written;
  }
  EXPECT_GT(with_places, 500);
}

TEST(German, NoEnglishWordIsLeftInTheSummary) {
  const Speaking speaking(kGerman);
  const ReportInput input = full_example();
  const std::string text = summary_text(input.accuracy, &*input.deviation, &*input.changes);
  for (const std::string& line : english_in({text}, kGiven)) ADD_FAILURE() << line;
  EXPECT_NE(text.find("Toleranz 5,00 mm"), std::string::npos) << text;
}

TEST(German, TheStochasticModelOfASurveyIsASentenceForEachInstrument) {
  const Speaking speaking(kGerman);
  const std::string text = spoken(
      "Precision assumed, one: directions 5.0\u2033, zenith angles 5.0\u2033 (one set in both faces), distances 2.0 mm "
      "+ "
      "2.0 ppm, centring of targets 0.5 mm, of the instrument 0.0 mm where it stands over a mark; used for 9 of 10 "
      "readings, whose files give no standard deviation; two: directions 1.0\u2033, zenith angles 1.0\u2033 (one set "
      "in "
      "both faces), distances 1.0 mm + 1.5 ppm, centring of targets 0.3 mm, of the instrument 0.2 mm where it stands "
      "over a mark; its centring is added to 1 of 10 readings, whose files give standard deviations without it.");
  EXPECT_TRUE(text.starts_with("Angenommene Genauigkeit, one: Richtungen 5,0\u2033, Zenitwinkel 5,0\u2033")) << text;
  for (const char* part : {"Strecken 2,0", "verwendet für 9 von 10 Ablesungen", "; two: Richtungen 1,0\u2033",
                           "die Standardabweichungen von 1 von 10 Ablesungen"})
    EXPECT_NE(text.find(part), std::string::npos) << part << " is not in: " << text;
}

/// The test above would find one.
TEST(German, AnEnglishWordIsFound) {
  EXPECT_EQ(english_in({"Anker außerhalb, alles unentschieden"}, {}).size(), 0u);
  EXPECT_EQ(english_in({"Anker nicht measured"}, {}).size(), 1u);
  EXPECT_EQ(english_in({"Measure it."}, {}).size(), 1u);
}

TEST(German, NamesStayAsTheyAre) {
  const Speaking speaking(kGerman);
  ReportInput input = test::example();
  input.deviation->anchors[0]->id = input.accuracy.anchors[0]->id = "Floor";
  for (auto& panel : input.deviation->panels)
    for (auto& fixing : panel->fixings)
      if (fixing->anchor == "F01-C01-R1") fixing->anchor = "Floor";
  input.deviation->panels[0]->name = "Panel 3";
  const std::string html = render_report(input);
  EXPECT_NE(html.find("<th scope=\"row\">Floor</th>"), std::string::npos);
  EXPECT_NE(html.find("<th scope=\"row\">Panel 3</th>"), std::string::npos);
  for (const char mark : {'\x01', '\x02', '\x03'}) EXPECT_EQ(html.find(mark), std::string::npos) << "a mark came out";
}

TEST(German, EnglishIsAsItWas) {
  const ReportInput input = full_example();
  const std::string before = render_report(input);
  {
    const Speaking speaking(kGerman);
    EXPECT_NE(render_report(input), before);
  }
  EXPECT_EQ(render_report(input), before) << "a language ends with its scope";
  EXPECT_EQ(before.find("id=\"spoken\">"), std::string::npos);
  EXPECT_EQ(spoken("Measure it."), "Measure it.");
}

}  // namespace test_language
}  // namespace plumbline::report
