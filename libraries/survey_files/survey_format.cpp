#include "survey_files/survey_format.hpp"

#include <array>
#include <cstddef>
#include <vector>

#include "survey_files/gama.hpp"
#include "survey_files/gsi.hpp"
#include "survey_files/gsi_words.hpp"
#include "survey_files/jobxml.hpp"
#include "survey_files/krumm.hpp"
#include "survey_files/landxml.hpp"
#include "survey_files/rw5.hpp"
#include "survey_files/sdr33.hpp"
#include "survey_files/survey_builder.hpp"
#include "survey_files/survey_csv.hpp"
#include "survey_files/survey_csv_columns.hpp"
#include "text/csv_table.hpp"
#include "text/text.hpp"

namespace plumbline::survey {
namespace {

constexpr std::size_t kBeginning = 65536;
constexpr std::size_t kLinesLookedAt = 60;

// Name of the root element, without prefix; empty if `text` is no XML. Passes over declarations, comments and DOCTYPE.
std::string_view root_element(std::string_view text) {
  for (text = formats::trim(text); text.starts_with('<');) {
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
    text = formats::trim(text);
  }
  return {};
}

std::optional<SurveyFormat> xml_format(std::string_view text) {
  const std::string_view root = root_element(text);
  if (root == "LandXML") return SurveyFormat::landxml;
  if (root == "JOBFile") return SurveyFormat::jobxml;
  if (root == "gama-local" || root == "gama-xml") return SurveyFormat::gama_xml;
  return std::nullopt;
}

// Lines of each kind among the first ones; a format is taken when it explains at least half of them.
std::optional<SurveyFormat> line_format(const std::vector<formats::Line>& lines) {
  static constexpr std::array<std::string_view, 14> kRw5 = {"JB,", "MO,", "OC,", "BK,", "LS,", "SS,",  "TR,",
                                                            "BD,", "BR,", "FD,", "FR,", "SP,", "GPS,", "--"};
  std::size_t looked_at = 0, gsi = 0, sdr = 0, rw5 = 0, comments = 0;
  bool sections = false;
  std::vector<GsiNoise> noise;
  for (const formats::Line& line : lines) {
    const std::string_view text = formats::trim(line.text);
    if (text.empty()) continue;
    if (++looked_at > kLinesLookedAt) break;
    noise.clear();
    if (!gsi_blocks({text.substr(0, 1000), line.number}, noise).empty() && noise.empty()) ++gsi;
    const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
    const auto is_tag = [&](char c) { return is_digit(c) || (c >= 'A' && c <= 'Z'); };
    if (text.size() >= 4 && is_digit(text[0]) && is_digit(text[1]) && is_tag(text[2]) && is_tag(text[3]) &&
        !(is_digit(text[2]) && is_digit(text[3])))
      ++sdr;
    for (const std::string_view start : kRw5)
      if (text.starts_with(start)) {
        ++rw5;
        break;
      }
    if (text.front() == '#' || text.front() == '%') ++comments;
    const std::string section = formats::to_lower(text);
    sections = sections || section.starts_with("[coordinates]") || section.starts_with("[spatialdistances]") ||
               section.starts_with("[datum]");
  }
  const auto explains = [&](std::size_t count) { return count > 0 && 2 * count >= looked_at - comments; };
  if (sections) return SurveyFormat::krumm;
  if (explains(gsi)) return SurveyFormat::gsi;
  if (explains(sdr)) return SurveyFormat::sdr33;
  if (explains(rw5)) return SurveyFormat::rw5;
  return std::nullopt;
}

// Half the rows with a name and two numbers, or a header we know.
bool looks_like_table(std::string_view text) {
  const formats::CsvTable table = formats::read_csv(text, survey_column_names());
  if (!table.header.empty()) return !table.rows.empty();
  std::size_t good = 0, rows = 0;
  for (const formats::CsvRow& row : table.rows) {
    if (++rows > kLinesLookedAt) break;
    if (row.cells.size() >= 3 && table.number(row.cells[1]) && table.number(row.cells[2])) ++good;
  }
  return good > 0 && 2 * good >= std::min(rows, kLinesLookedAt);
}

std::optional<SurveyFormat> suffix_format(const std::string& file_name) {
  const std::string name = formats::to_lower(file_name);
  static constexpr std::array<std::pair<std::string_view, SurveyFormat>, 9> kSuffixes = {{
      {".gsi", SurveyFormat::gsi},
      {".jxl", SurveyFormat::jobxml},
      {".jobxml", SurveyFormat::jobxml},
      {".sdr", SurveyFormat::sdr33},
      {".rw5", SurveyFormat::rw5},
      {".gkf", SurveyFormat::gama_xml},
      {".landxml", SurveyFormat::landxml},
      {".hexml", SurveyFormat::landxml},
      {".csv", SurveyFormat::csv},
  }};
  for (const auto& [suffix, format] : kSuffixes)
    if (name.ends_with(suffix)) return format;
  return std::nullopt;
}

}  // namespace

const char* short_name(SurveyFormat format) {
  static constexpr const char* kNames[] = {"gsi",   "landxml",           "jobxml", "sdr33", "rw5", "gama-xml",
                                           "krumm", "setup-coordinates", "csv"};
  return kNames[static_cast<std::size_t>(format)];
}

const char* long_name(SurveyFormat format) {
  static constexpr const char* kNames[] = {
      "Leica GSI",   "LandXML survey", "Trimble JobXML", "Sokkia SDR33",
      "Carlson RW5", "gama-local XML", "Krumm .dat",     "CSV of coordinates in each set-up",
      "CSV table"};
  return kNames[static_cast<std::size_t>(format)];
}

std::optional<SurveyFormat> detect_survey_format(std::string_view bytes, const std::string& file_name) {
  // An even number of bytes, so that UTF-16 is not cut inside a unit.
  const formats::DecodedText decoded = formats::decode_text(bytes.substr(0, kBeginning));
  const std::string_view text = formats::trim(decoded.text);
  if (text.empty()) return std::nullopt;
  if (text.front() == '<') {
    const auto format = xml_format(text);
    return format ? format : suffix_format(file_name);
  }
  if (const auto format = line_format(formats::split_lines(text))) return format;
  if (has_setup_coordinates_header(text)) return SurveyFormat::setup_coordinates;
  if (looks_like_table(text)) return SurveyFormat::csv;
  return suffix_format(file_name);
}

SurveyObservations read_survey(std::string_view bytes, const std::string& file) {
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
        return read_survey_csv(bytes, file);
      case SurveyFormat::gama_xml:
        return read_gama_xml(bytes, file);
    }
  }
  const formats::DecodedText decoded = formats::decode_text(bytes.substr(0, kBeginning));
  const std::string_view text = formats::trim(decoded.text);
  const std::string_view first = text.substr(0, text.find_first_of("\r\n"));
  throw SurveyReadError({file, text.empty() ? 0 : 1, text.empty() ? 0 : 1},
                        text.empty() ? "an empty file (" + std::to_string(bytes.size()) + " bytes)"
                                     : "a file that begins with " + formats::quoted(first),
                        understood_formats());
}

}  // namespace plumbline::survey
