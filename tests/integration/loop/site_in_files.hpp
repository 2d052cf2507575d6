// A site, simulated, that goes into site_loop.yaml as files only: a folder for each campaign, reports, states.
#pragma once

#include <nlohmann/json.hpp>

#include "geometry/random.hpp"
#include "loop/job/job.hpp"
#include "program.hpp"
#include "test_paths.hpp"

namespace plumbline::test {

using Json = nlohmann::json;
namespace fs = std::filesystem;

inline constexpr const char* kStart = R"(plumbline: 1
nodes:
  start: {use: simulate.campaign, with: {floors: 2, columns: 3, photographs: observed}}
outputs: {site: start.folder, truth: start.truth}
)";

/// Truth in, readings of a total station out, as the file that a surveyor brings.
inline constexpr const char* kMeasure = R"(plumbline: 1
vars: {truth: ~}
nodes:
  truth: {use: read.points, with: {file: "${truth}"}}
  site: {use: simulate.site, in: {truth: truth.points}}
  readings: {use: simulate.survey, in: {markers: site.markers, set_ups: site.set_ups}, with: {sets: 8}}
  file: {use: write.survey_csv, in: {observations: readings.observations}}
outputs: {readings.csv: file.file, control.json: site.control}
)";

inline std::string day(int number, const char* time) {
  char text[40];
  std::snprintf(text, sizeof text, "2026-05-%02dT%s:00Z", number, time);
  return text;
}

/// How the design lies in the survey: where its origin is, and by how much it is turned.
struct SurveyFrame {
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  double degrees = 0;

  double angle() const { return degrees * 3.14159265358979323846 / 180; }
  Eigen::Matrix3d turn() const { return Eigen::AngleAxisd(angle(), Eigen::Vector3d::UnitZ()).toRotationMatrix(); }
  Eigen::Vector3d survey(const Eigen::Vector3d& building) const { return origin + turn() * building; }
  Eigen::Vector3d building(const Eigen::Vector3d& survey) const { return turn().transpose() * (survey - origin); }
  std::vector<std::string> words() const {
    char text[200];
    std::snprintf(text, sizeof text, "frames.with.translation=[%.4f, %.4f, %.4f]", origin.x(), origin.y(), origin.z());
    return {"frames.with.use=given", text, "frames.with.rotation=" + std::to_string(angle()),
            "frames.with.sigmas=[0.00001, 0.0005, 0.0005, 0.0005]"};
  }
};

/// Where hooks are, and robots that do what a job says to a tenth of a millimetre.
class Site {
 public:
  explicit Site(const Program& plumbline, SurveyFrame frame = {}) : plumbline_(plumbline), frame_(frame) {
    plumbline.write("start.yaml", kStart), plumbline.write("measure.yaml", kMeasure);
    const Answer answer = plumbline({"run", "start.yaml", "--out", "start", "seed=3"});
    if (answer.code != 0) throw std::runtime_error(answer.err);
    std::istringstream rows(read_file(plumbline.work() / "start/truth/anchors.csv"));
    std::string row;
    std::getline(rows, head_);
    while (std::getline(rows, row))
      if (!row.empty()) truth_.push_back(row);
  }

  /// A campaign folder of what stands now; anchors whose name begins with `but` are not measured.
  void measure(int round, const std::string& but = "none") {
    std::string table = "id,E,N,H\n";
    for (const std::string& row : truth_) {
      const auto [name, place] = read(row);
      if (name.rfind(but, 0) == 0) continue;
      char text[200];
      std::snprintf(text, sizeof text, "%s,%.6f,%.6f,%.6f\n", name.c_str(), place.x(), place.y(), place.z());
      table += text;
    }
    plumbline_.write("truth.csv", table);
    const std::string out = "measured" + std::to_string(round), folder = "campaign" + std::to_string(round);
    const Answer answer =
        plumbline_({"run", "measure.yaml", "--out", out, "truth=truth.csv", "seed=" + std::to_string(round)});
    if (answer.code != 0) throw std::runtime_error(answer.err);
    fs::create_directory(plumbline_.work() / folder);
    fs::copy_file(plumbline_.work() / "start/site/design.ifc", plumbline_.work() / folder / "design.ifc");
    plumbline_.write(folder + "/plates.csv", turned_plates());
    fs::copy_file(plumbline_.work() / out / "readings.csv", plumbline_.work() / folder / "readings.csv");
    std::string control = "id,E,N,H,sE_mm,sN_mm,sH_mm\n";
    const Json marks = Json::parse(read_file(plumbline_.work() / out / "control.json"));
    for (const Json& point : marks["points"]) {
      const Json& given = point["position"];
      const Eigen::Vector3d p = frame_.survey({given[0].get<double>(), given[1].get<double>(), given[2].get<double>()});
      char text[200];
      std::snprintf(text, sizeof text, "%s,%.6f,%.6f,%.6f,0.3,0.3,0.3\n", point["id"].get<std::string>().c_str(), p.x(),
                    p.y(), p.z());
      control += text;
    }
    plumbline_.write(folder + "/control.csv", control);
    plumbline_.write(folder + "/campaign.yaml",
                     "plumbline_campaign: 1\nsurvey: readings.csv\nplates: plates.csv\ndesign: design.ifc\ncontrol: "
                     "control.csv\ndate: 2026-05-01\n");
  }

  /// Does the job of a round, and reports it the day after. Returns the number of items.
  std::size_t work(int round) {
    const loop::Job job = loop::read_job(read_file(plumbline_.work() / ("round" + std::to_string(round)) / "job.json"));
    if (job.frame != (frame_.degrees == 0 ? "building" : "survey")) throw std::runtime_error("a job in " + job.frame);
    Random luck(7, "robot", static_cast<std::uint64_t>(round));
    Json reports;
    reports["items"] = Json::array();
    for (const loop::JobItem& item : job.items) {
      Json report{{"item", item.id},
                  {"job", job.id},
                  {"revision", item.revision},
                  {"by", "robot-1"},
                  {"at", day(round + 1, "06:00")},
                  {"frame", job.frame},
                  {"outcome", "done"}};
      if (item.kind == "bracket")
        move(item.id, frame_.turn().transpose() * (item.design_rotation * (item.setting + luck.normal3(0.0001))));
      else
        for (int k = 0; k < 3; ++k) report["measured"].push_back(job.origin[k] + item.target[k] + luck.normal(0.001));
      reports["items"].push_back(report);
    }
    plumbline_.write("actuals" + std::to_string(round) + ".json", reports.dump());
    return job.items.size();
  }

  void move(const std::string& name, const Eigen::Vector3d& by) {
    for (std::string& row : truth_) {
      auto [id, place] = read(row);
      if (id != name) continue;
      place += by;
      char text[200];
      std::snprintf(text, sizeof text, "%s,%.6f,%.6f,%.6f", id.c_str(), place.x(), place.y(), place.z());
      row = text;
    }
  }

  /// Where the hook of a bracket is, in the frame of the survey.
  Eigen::Vector3d place(const std::string& name) const {
    for (const std::string& row : truth_)
      if (const auto [id, place] = read(row); id == name) return frame_.survey(place);
    throw std::runtime_error(name + " is no anchor");
  }

  std::vector<std::string> names() const {
    std::vector<std::string> all;
    for (const std::string& row : truth_) all.push_back(read(row).first);
    return all;
  }

 private:
  /// Azimuths of plates count from the north of the survey.
  std::string turned_plates() const {
    std::istringstream rows(read_file(plumbline_.work() / "start/site/plates.csv"));
    std::string text, row;
    std::getline(rows, row);
    std::istringstream heads(row);
    std::size_t column = 0;
    for (std::string head; std::getline(heads, head, ',') && head != "facing_azimuth_deg";) ++column;
    text = row + "\n";
    while (std::getline(rows, row)) {
      std::istringstream cells(row);
      std::size_t at = 0;
      for (std::string cell; std::getline(cells, cell, ','); ++at)
        text += (at > 0 ? "," : "") + (at == column ? std::to_string(std::stod(cell) - frame_.degrees) : cell);
      text += "\n";
    }
    return text;
  }

  /// Of a row of truth/anchors.csv, or one of ours.
  std::pair<std::string, Eigen::Vector3d> read(const std::string& row) const {
    std::vector<std::string> cells;
    std::istringstream stream(row);
    for (std::string cell; std::getline(stream, cell, ',');) cells.push_back(cell);
    const std::size_t first = cells.size() > 4 ? 8 : 1;  // x_m, y_m, z_m
    return {cells.at(0), {std::stod(cells[first]), std::stod(cells[first + 1]), std::stod(cells[first + 2])}};
  }

  const Program& plumbline_;
  SurveyFrame frame_;
  std::string head_;
  std::vector<std::string> truth_;
};

inline Answer run_round(const Program& plumbline, int round, std::vector<std::string> more = {},
                        const std::string& out = {}) {
  const std::string number = std::to_string(round), before = std::to_string(round - 1);
  std::vector<std::string> words = {"run",
                                    std::string(source_dir()) + "/pipelines/site_loop.yaml",
                                    "--out",
                                    out.empty() ? "round" + number : out,
                                    "folder=campaign" + number,
                                    "now=" + day(round, "16:00"),
                                    "measured=" + day(round, "09:00"),
                                    R"(plan.with.brackets=["*: right=20mm, up=15mm, out=25mm"])",
                                    "mounting_sigma=0"};
  if (round == 1)
    words.push_back("first=true");
  else
    words.insert(words.end(),
                 {"state=round" + before + "/state.json", "reports.with.json=[actuals" + before + ".json]"});
  words.insert(words.end(), more.begin(), more.end());
  return plumbline(words);
}

}  // namespace plumbline::test
