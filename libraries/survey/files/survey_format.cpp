#include "survey/files/survey_format.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

#include "base/text/csv_table.hpp"
#include "base/text/text.hpp"
#include "survey/files/dynaml.hpp"
#include "survey/files/field_books.hpp"
#include "survey/files/gama.hpp"
#include "survey/files/gsi.hpp"
#include "survey/files/gsi_words.hpp"
#include "survey/files/jobxml.hpp"
#include "survey/files/krumm.hpp"
#include "survey/files/krumm_sections.hpp"
#include "survey/files/landxml.hpp"
#include "survey/files/rw5.hpp"
#include "survey/files/sdr33.hpp"
#include "survey/files/starnet.hpp"
#include "survey/files/survey_builder.hpp"
#include "survey/files/survey_csv.hpp"
#include "survey/files/survey_csv_columns.hpp"
#include "survey/files/zeiss.hpp"

namespace plumbline::survey {
namespace {

constexpr std::size_t kBeginning = 16384;
constexpr std::size_t kLinesLookedAt = 60;

// Name of the root element, without prefix; empty if `text` is no XML. Passes over declarations, comments and DOCTYPE.
std::string_view root_element(std::string_view text) {
  for (text = text::trim(text); text.starts_with('<');) {
    if (text.starts_with("<!--")) {
      const std::size_t end = text.find("-->");
      if (end == std::string_view::npos) return {};
      text.remove_prefix(end + 3);
    } else if (text.starts_with("<?") || text.starts_with("<!")) {
      // A DOCTYPE may hold declarations with '>' of their own in brackets.
      const std::size_t bracket = text.find('['), close = text.find('>');
      const std::size_t end = bracket < close ? text.find("]>") : close;
      if (end == std::string_view::npos) return {};
      text.remove_prefix(end + (bracket < close ? 2 : 1));
    } else {
      std::string_view name = text.substr(1, text.find_first_of(" \t\r\n/>", 1) - 1);
      const std::size_t colon = name.rfind(':');
      return colon == std::string_view::npos ? name : name.substr(colon + 1);
    }
    text = text::trim(text);
  }
  return {};
}

std::optional<SurveyFormat> xml_format(std::string_view text) {
  const std::string_view root = root_element(text);
  if (root == "LandXML") return SurveyFormat::landxml;
  if (root == "DnaXmlFormat") return SurveyFormat::dynaml;
  if (root == "JOBFile") return SurveyFormat::jobxml;
  if (root == "gama-local" || root == "gama-xml" || root == "gnu-gama-data") return SurveyFormat::gama_xml;
  return std::nullopt;
}

bool is_digit(char c) { return c >= '0' && c <= '9'; }

template <std::size_t N>
bool begins_with_any(std::string_view text, const std::array<std::string_view, N>& beginnings) {
  return std::any_of(beginnings.begin(), beginnings.end(), [&](std::string_view b) { return text.starts_with(b); });
}

bool is_gsi(std::string_view text) {
  std::vector<GsiNoise> noise;
  return !gsi_blocks({text.substr(0, 1000), 1}, noise).empty() && noise.empty();
}

// Two digits and two letters, or letter and digit: "09F1".
bool is_sdr(std::string_view text) {
  const auto is_tag = [](char c) { return is_digit(c) || (c >= 'A' && c <= 'Z'); };
  return text.size() >= 4 && is_digit(text[0]) && is_digit(text[1]) && is_tag(text[2]) && is_tag(text[3]) &&
         !(is_digit(text[2]) && is_digit(text[3]));
}

bool is_rw5(std::string_view text) {
  static constexpr std::array<std::string_view, 14> kRecords = {"JB,", "MO,", "OC,", "BK,", "LS,", "SS,OP", "TR,",
                                                                "BD,", "BR,", "FD,", "FR,", "SP,", "GPS,",  "--"};
  return begins_with_any(text, kRecords);
}

bool is_nikon(std::string_view text) {
  static constexpr std::array<std::string_view, 11> kRecords = {"CO,", "ST,", "F1,", "F2,", "MP,", "MC,",
                                                                "UP,", "CC,", "RE,", "SO,", "SS,"};
  return begins_with_any(text, kRecords) && !text.starts_with("SS,OP");
}

bool is_gts7(std::string_view text) {
  static constexpr std::array<std::string_view, 14> kKeys = {
      "JOB ", "INST ", "UNITS ", "STN ", "XYZ ", "BKB ", "BS ", "FS ", "SS ", "SD ", "HV ", "HD ", "DATE ", "TEMP "};
  return begins_with_any(text, kKeys) && text.find(',') != std::string_view::npos;
}

bool is_geodimeter(std::string_view text) {
  const std::size_t equals = text.find('=');
  return equals != std::string_view::npos && equals > 0 && equals <= 3 &&
         std::all_of(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(equals), is_digit);
}

enum class StarNetLine { no, weak, strong };

// A table may have points called A or C: only options, names that are joined and direction sets are sure.
StarNetLine starnet_line(std::string_view text, char& separator) {
  const auto parts = text::split_blanks(text);
  if (parts.empty()) return StarNetLine::no;
  const std::string code = text::to_lower(parts[0]);
  if (code.starts_with(".sep") && parts.size() == 2 && parts[1].size() == 1) separator = parts[1].front();
  for (const char* option : {".separator", ".units", ".order", ".3d", ".2d", ".delta", ".gps", ".inst", ".lweight"})
    if (code == option) return StarNetLine::strong;
  if (parts.size() < 2) return StarNetLine::no;
  for (const char* joined : {"a", "d", "v", "b", "m", "bm", "dv", "ss", "l", "g1"})
    if (code == joined && parts.size() > 2)
      return parts[1].find(separator, 1) != std::string_view::npos && !text::parse_number(parts[1])
                 ? StarNetLine::strong
                 : StarNetLine::no;
  for (const char* set : {"db", "dn", "dm", "tb", "te"})
    if (code == set) return StarNetLine::strong;
  for (const char* alone : {"c", "e", "t", "g0", "g2", "g3"})
    if (code == alone) return StarNetLine::weak;
  return StarNetLine::no;
}

bool is_krumm_section(std::string_view text) {
  if (!text.starts_with('[')) return false;
  const auto section = krumm_section(text.substr(1, std::min(text.find(']'), text.size()) - 1));
  return section && text.find(']') != std::string_view::npos;
}

// Lines of each kind among the first ones; a format is taken when it explains at least half of them.
std::optional<SurveyFormat> line_format(std::string_view beginning) {
  std::size_t looked_at = 0, gsi = 0, sdr = 0, rw5 = 0, nikon = 0, gts7 = 0, geodimeter = 0, zeiss = 0, comments = 0;
  std::size_t starnet = 0, starnet_sure = 0;
  char separator = '-';  // of STAR*NET's names
  bool sections = false;
  for (const text::Line& line : text::split_lines(beginning)) {
    const std::string_view text = text::trim(line.text);
    if (text.empty() || text == "?") continue;  // '?': STX, ETX
    if (++looked_at > kLinesLookedAt) break;
    gsi += is_gsi(text);
    sdr += is_sdr(text);
    rw5 += is_rw5(text);
    nikon += is_nikon(text);
    gts7 += is_gts7(text);
    geodimeter += is_geodimeter(text);
    zeiss += text.starts_with("For M5|") || text.starts_with("For R5|") || text.starts_with("For R4|");
    comments += text.front() == '#' || text.front() == '%';
    sections = sections || is_krumm_section(text);
    const StarNetLine kind = starnet_line(text, separator);
    starnet += kind != StarNetLine::no;
    starnet_sure += kind == StarNetLine::strong;
  }
  const auto explains = [&](std::size_t count) { return count > 0 && 2 * count >= looked_at - comments; };
  if (sections) return SurveyFormat::krumm;
  if (explains(zeiss)) return SurveyFormat::zeiss;
  if (explains(gsi)) return SurveyFormat::gsi;
  if (explains(sdr)) return SurveyFormat::sdr33;
  if (explains(nikon) && nikon > rw5) return SurveyFormat::nikon;
  if (explains(rw5)) return SurveyFormat::rw5;
  if (explains(gts7)) return SurveyFormat::topcon_gts7;
  if (explains(geodimeter)) return SurveyFormat::geodimeter;
  if (starnet_sure > 0 && explains(starnet)) return SurveyFormat::starnet;
  return std::nullopt;
}

// Formats that show by how they begin.
std::optional<SurveyFormat> format_by_beginning(std::string_view text) {
  if (text.starts_with('?')) text = text::trim(text.substr(1));  // STX
  if (text.starts_with("_'") && text.find("_+") != std::string_view::npos) return SurveyFormat::topcon_gts210;
  if (is_topcon_level(text.substr(0, text.find_first_of("\r\n")))) return SurveyFormat::topcon_level;
  if (text.starts_with("HEADER") && text.find("DATABASE") != std::string_view::npos) return SurveyFormat::idx;
  return std::nullopt;
}

// Half the rows with a name and two numbers, or a header we know.
bool looks_like_table(std::string_view text) {
  const text::CsvTable table = text::read_csv(text, survey_column_names());
  if (!table.header.empty()) return !table.rows.empty();
  std::size_t good = 0, rows = 0;
  for (const text::CsvRow& row : table.rows) {
    if (++rows > kLinesLookedAt) break;
    if (row.cells.size() >= 3 && table.number(row.cells[1]) && table.number(row.cells[2])) ++good;
  }
  return good > 0 && 2 * good >= std::min(rows, kLinesLookedAt);
}

std::optional<SurveyFormat> suffix_format(const std::string& file_name) {
  const std::string name = text::to_lower(file_name);
  static constexpr std::array<std::pair<std::string_view, SurveyFormat>, 13> kSuffixes = {{
      {".gsi", SurveyFormat::gsi},
      {".jxl", SurveyFormat::jobxml},
      {".jobxml", SurveyFormat::jobxml},
      {".sdr", SurveyFormat::sdr33},
      {".rw5", SurveyFormat::rw5},
      {".gkf", SurveyFormat::gama_xml},
      {".landxml", SurveyFormat::landxml},
      {".hexml", SurveyFormat::landxml},
      {".csv", SurveyFormat::csv},
      {".m5", SurveyFormat::zeiss},
      {".are", SurveyFormat::geodimeter},
      {".gts7", SurveyFormat::topcon_gts7},
      {".idx", SurveyFormat::idx},
  }};
  for (const auto& [suffix, format] : kSuffixes)
    if (name.ends_with(suffix)) return format;
  return std::nullopt;
}

// ".trk" of a name under which nobody keeps tables; empty for names of tables and names without a suffix.
std::string foreign_suffix(const std::string& file) {
  const std::string name = text::to_lower(file);
  const std::size_t dot = name.rfind('.'), slash = name.rfind('/');
  if (dot == std::string::npos || dot + 1 == name.size() || (slash != std::string::npos && dot < slash)) return "";
  const std::string suffix = name.substr(dot);
  for (const char* of_tables : {".csv", ".txt", ".tsv", ".dat", ".asc", ".pts", ".xyz", ".pnt", ".prn", ".pkt", ".koo",
                                ".kor", ".coo", ".neu", ".enz", ".tab", ".lst"})
    if (suffix == of_tables) return "";
  return suffix;
}

// Rows with a name and numbers look like points, whatever they are. Under a name that is of no table it is said that
// they were taken for some, and what is no point in them is no fault of a column.
SurveyObservations read_table(std::string_view bytes, const std::string& file, const std::string& angle_unit) {
  const SurveyCsvOptions options{"", angle_unit, ""};
  const std::string suffix = foreign_suffix(file);
  if (suffix.empty() || !text::read_csv(bytes, survey_column_names()).header.empty())
    return read_survey_csv(bytes, file, options);
  const std::string reader = "a plugin that reads *" + suffix +
                             ": one whose parameter `files` names it (docs/howto/sensor.md), on PLUMBLINE_PLUGIN_PATH";
  const auto refuse = [&](const std::string& why) {
    throw SurveyReadError({file, 1, 1},
                          "a file that is neither called like a format that is known nor looks like one; it is no "
                          "table of points either (" +
                              why + ")",
                          reader + "; or " + understood_formats());
  };
  SurveyObservations survey;
  try {
    survey = read_survey_csv(bytes, file, options);
  } catch (const SurveyReadError& error) {
    refuse("line " + std::to_string(error.source.line) + ": " + error.found);
  }
  if (!survey.skipped.empty())
    refuse("line " + std::to_string(survey.skipped.front().source.line) + ": " + survey.skipped.front().found);
  survey.warnings.push_back(
      "nothing but its rows says what this file is: they are taken as points with E, N and H in metres. "
      "If it is of an instrument, it takes " +
      reader);
  return survey;
}

}  // namespace

const char* short_name(SurveyFormat format) {
  static constexpr const char* kNames[] = {
      "gsi",           "landxml",           "jobxml",     "sdr33", "rw5",     "gama-xml",
      "krumm",         "setup-coordinates", "csv",        "zeiss", "nikon",   "topcon-gts7",
      "topcon-gts210", "topcon-dl",         "geodimeter", "idx",   "starnet", "dynaml"};
  return kNames[static_cast<size_t>(format)];
}

const char* long_name(SurveyFormat format) {
  static constexpr const char* kNames[] = {"Leica GSI",      "LandXML survey",
                                           "Trimble JobXML", "Sokkia SDR33",
                                           "Carlson RW5",    "gama-local XML",
                                           "Krumm .dat",     "CSV of coordinates in each set-up",
                                           "CSV table",      "Zeiss M5, R5 or R4",
                                           "Nikon RAW",      "Topcon GTS-7",
                                           "Topcon GTS-210", "Topcon DL or Sokkia SDL level",
                                           "Geodimeter",     "Leica IDX",
                                           "STAR*NET",       "DynaML"};
  return kNames[static_cast<size_t>(format)];
}

std::optional<SurveyFormat> detect_survey_format(std::string_view bytes, const std::string& file_name) {
  // An even number of bytes, so that UTF-16 is not cut inside a unit.
  const text::DecodedText decoded = text::decode_text(bytes.substr(0, kBeginning));
  const std::string_view text = text::trim(decoded.text);
  if (text.empty()) return std::nullopt;
  if (text.front() == '<') {
    const auto format = xml_format(text);
    return format ? format : suffix_format(file_name);
  }
  if (const auto format = format_by_beginning(text)) return format;
  if (const auto format = line_format(text)) return format;
  if (has_setup_coordinates_header(text)) return SurveyFormat::setup_coordinates;
  if (looks_like_table(text)) return SurveyFormat::csv;
  return suffix_format(file_name);
}

SurveyObservations read_survey(std::string_view bytes, const std::string& file, const std::string& angle_unit) {
  const auto format = detect_survey_format(bytes, file);
  if (format) {
    switch (*format) {
      case SurveyFormat::gsi:
        return read_gsi(bytes, file);
      case SurveyFormat::landxml:
        return read_landxml(bytes, file);
      case SurveyFormat::jobxml:
        return read_jobxml(bytes, file);
      case SurveyFormat::sdr33:
        return read_sdr33(bytes, file);
      case SurveyFormat::rw5:
        return read_rw5(bytes, file);
      case SurveyFormat::krumm:
        return read_krumm(bytes, file);
      case SurveyFormat::setup_coordinates:
        return read_setup_coordinates(bytes, file);
      case SurveyFormat::csv:
        return read_table(bytes, file, angle_unit);
      case SurveyFormat::gama_xml:
        return read_gama_xml(bytes, file);
      case SurveyFormat::zeiss:
        return read_zeiss(bytes, file);
      case SurveyFormat::nikon:
        return read_nikon(bytes, file);
      case SurveyFormat::topcon_gts7:
        return read_topcon_gts7(bytes, file);
      case SurveyFormat::topcon_gts210:
        return read_topcon_gts210(bytes, file);
      case SurveyFormat::topcon_level:
        return read_topcon_level(bytes, file);
      case SurveyFormat::geodimeter:
        return read_geodimeter(bytes, file);
      case SurveyFormat::idx:
        return read_idx(bytes, file);
      case SurveyFormat::starnet:
        return read_starnet(bytes, file);
      case SurveyFormat::dynaml:
        return read_dynaml(bytes, file);
    }
  }
  const text::DecodedText decoded = text::decode_text(bytes.substr(0, kBeginning));
  const std::string_view text = text::trim(decoded.text);
  const std::string_view first = text.substr(0, text.find_first_of("\r\n")), root = root_element(text);
  if (!root.empty())
    throw SurveyReadError({file, 1, 1}, "XML with the root element " + text::quoted(root), understood_formats());
  if (text.find("STAR*NET") < 400 && text.find("Run Date") != std::string_view::npos)
    throw SurveyReadError({file, 1, 1}, "the listing of a STAR*NET adjustment (" + text::quoted(first) + ")",
                          "the data that it was made of: the listing names them under 'Data File List' (.dat)");
  throw SurveyReadError({file, text.empty() ? 0 : 1, text.empty() ? 0 : 1},
                        text.empty() ? "an empty file (" + std::to_string(bytes.size()) + " bytes)"
                                     : "a file that begins with " + text::quoted(first),
                        understood_formats());
}

}  // namespace plumbline::survey
