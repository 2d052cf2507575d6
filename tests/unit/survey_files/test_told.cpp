// All that every reader takes from its fixture, and from files of rarer words, one line a thing: told/NAME.told.
#include <fmt/core.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "record.hpp"
#include "survey/files/survey_format.hpp"
#include "survey_test_support.hpp"

namespace plumbline::survey {
namespace test_told {

namespace fs = std::filesystem;

std::string number(double value) { return std::isnan(value) ? "-" : fmt::format("{:.10g}", value); }

std::string matrix(const Eigen::MatrixXd& m) {
  std::string text;
  for (Eigen::Index i = 0; i < m.rows(); ++i)
    for (Eigen::Index j = 0; j <= i; ++j) text += " " + number(m(i, j));
  return text;
}

std::string joined(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : "; ") + word;
  return text;
}

std::string told_of(const NetworkInfo& i) {
  return fmt::format(
      "file {} | title {} | {} | instrument {} {} | by {} | program {} | date {} | axes {} {} {} {} | sigma0 {} {} | "
      "level {} | refraction {} | system {} | misclosure {}\n",
      i.format, i.title, i.description, i.instrument, i.instrument_serial, i.operator_name, i.program, i.date,
      i.axes_xy, i.angles_right_handed, i.axes_inconsistent, i.angles_in_degrees ? "deg" : "gon",
      number(i.a_priori_sigma0), i.use_a_posteriori_sigma0, number(i.confidence_level),
      number(i.refraction_coefficient), i.coordinate_system, number(i.largest_misclosure));
}

std::string told_of(const Observation& o) {
  static const char* const kinds[] = {"direction",         "zenith", "slope",  "horizontal",
                                      "height difference", "angle",  "azimuth"};
  std::string text =
      fmt::format("{}: {} {} > {}{} = {} sigma {}", o.source.line, kinds[static_cast<size_t>(o.kind)], o.from, o.to,
                  o.second_to.empty() ? "" : " > " + o.second_to, number(o.value), number(o.sigma));
  text += fmt::format(" | set-up {} pointing {} face {} set {} instrument {}", o.set_up, o.pointing, o.face,
                      o.set_number, o.instrument);
  text += fmt::format(" | heights {} {} {}", number(o.instrument_height), number(o.target_height),
                      number(o.second_target_height));
  if (!std::isnan(o.levelling_length)) text += " | length " + number(o.levelling_length);
  if (o.without_centring) text += " | centring is to be added";
  if (!o.corrections.empty()) text += " | " + joined(o.corrections);
  return text + "\n";
}

std::string told_of(const Point& p) {
  std::string text = fmt::format("{}: point {}", p.source.line, p.id);
  static const char* const roles[] = {"unused", "free", "constrained", "fixed"};
  for (size_t k = 0; k < 3; ++k)
    text += fmt::format(" {} {}{}", number(p.coordinates[static_cast<Eigen::Index>(k)]),
                        roles[static_cast<size_t>(p.roles[k])], p.known[k] ? " known" : "");
  return text + (p.code + p.description).insert(0, p.code.empty() && p.description.empty() ? "" : " | ") + "\n";
}

std::string told_of(const SurveyObservations& s) {
  std::string text = told_of(s.info);
  for (const Point& p : s.points) text += told_of(p);
  for (const SetUp& u : s.set_ups)
    text += fmt::format("{}: set-up {} on {} height {} orientation {}\n", u.source.line, u.id, u.station,
                        number(u.instrument_height), number(u.stated_orientation));
  for (const Observation& o : s.observations) text += told_of(o);
  for (const ObservationCovariance& c : s.covariances) {
    text += "covariance of";
    for (const int i : c.indices) text += " " + std::to_string(i);
    text += ":" + matrix(c.covariance) + "\n";
  }
  for (const CoordinateGroup& g : s.coordinates) {
    text += fmt::format("{}: {}coordinates", g.source.line, g.is_control ? "control " : "");
    for (size_t k = 0; k < g.components.size(); ++k)
      text += fmt::format(" {}{} {}", "ENH"[g.components[k].axis], g.components[k].point,
                          number(g.values[static_cast<Eigen::Index>(k)]));
    text += " |" + matrix(g.covariance) + "\n";
  }
  for (const VectorGroup& g : s.vectors) {
    text += fmt::format("{}: vectors {} {} {}", g.source.line, g.is_geocentric ? "of the earth" : "local",
                        number(g.horizontal_factor), number(g.vertical_factor));
    for (const auto& v : g.vectors)
      text += fmt::format(" {} {} > {} {}", v.from, number(v.from_height), v.to, number(v.to_height));
    text += ":";
    for (const double value : g.values) text += " " + number(value);
    text += " |" + matrix(g.covariance) + "\n";
  }
  for (const LocalCoordinate& c : s.local_coordinates)
    text += fmt::format("{}: local {} in {} {} {} {} | target {} |{}\n", c.source.line, c.point, c.set_up,
                        number(c.position.x()), number(c.position.y()), number(c.position.z()), number(c.target_height),
                        matrix(c.covariance));
  for (const std::string& name : s.instruments) text += "instrument " + name + "\n";
  for (const SkippedLine& skipped : s.skipped)
    text += fmt::format("skipped {}:{}: {} | expected {}\n", skipped.source.line, skipped.source.column, skipped.found,
                        skipped.expected);
  for (const std::string& warning : s.warnings) text += "warning: " + warning + "\n";
  return text;
}

TEST(Told, AllOfEveryFixture) {
  const std::string here = "unit/survey_files/";
  std::vector<fs::path> files;
  for (const char* folder : {"fixtures", "told"})
    for (const auto& entry : fs::directory_iterator(fs::path(test::source_dir()) / "tests" / here / folder))
      if (entry.path().extension() != ".told") files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  for (const fs::path& file : files) {
    const std::string name = file.filename().string();
    std::string told;
    try {
      told = told_of(read_survey(test::read_file(file), name));
    } catch (const SurveyReadError& error) {
      told = "refused: " + std::string(error.what()) + "\n";
    }
    test::expect_recorded(here + "told/" + name + ".told", told);
  }
}

}  // namespace test_told
}  // namespace plumbline::survey
