#include "photo/block/control_list.hpp"

#include <algorithm>
#include <map>
#include <set>
#include <stdexcept>

#include "base/text/text.hpp"
#include "control/points/control_files.hpp"
#include "photo/block/block_text.hpp"
#include "photo/block/control_words.hpp"

namespace plumbline::block {
namespace {

/// Leaves out control that is another point than the block's of that number, by its distances to the others.
void drop_strangers(ReadBlock& read, const std::vector<std::string>& labels) {
  PointBlock& block = read.block;
  BlockControl& control = block.control;
  std::vector<Eigen::Vector3d> in_block, in_control;
  for (size_t k = 0; k < control.points.size(); ++k) {
    in_block.push_back(block.points[control.points[k]].position);
    in_control.emplace_back(control.position.segment<3>(3 * static_cast<Eigen::Index>(k)));
  }
  const std::vector<size_t> strangers = strangers_in_figure(in_block, in_control);
  if (strangers.empty()) return;
  std::vector<std::string> names;
  BlockControl kept;
  std::vector<Eigen::Index> rows;
  for (size_t k = 0; k < control.points.size(); ++k) {
    // A check point that is off is what it is there to tell.
    if (!control.is_check[k] && std::find(strangers.begin(), strangers.end(), k) != strangers.end()) {
      names.push_back(labels[k]);
      continue;
    }
    kept.points.push_back(control.points[k]);
    kept.is_check.push_back(control.is_check[k]);
    for (Eigen::Index c = 0; c < 3; ++c) rows.push_back(3 * static_cast<Eigen::Index>(k) + c);
  }
  if (names.empty()) return;
  kept.position = control.position(rows);
  kept.covariance = control.covariance(rows, rows);
  control = kept;
  read.left_out.push_back("control " + few_of(names) +
                          ": other points in the block than in the list, by most of their distances to the rest of the "
                          "control; number the list as the block is");
  read.contradictions.push_back(read.left_out.back());
}

control::ControlTable read_list(const std::filesystem::path& file, ReadBlock& read) {
  std::string bytes;
  for (const std::string& line : lines_of(file)) bytes += line + "\n";
  control::ControlOptions options;
  options.has_second_names = true;
  control::ControlTable list = control::parse_control(bytes, file.string(), options);
  control::require_whole(list, file.string(), "a block");
  if (!list.axes.empty()) read.notes.push_back(file.string() + ": " + list.axes);
  for (const std::string& note : list.notes) read.notes.push_back(file.string() + ": " + note);
  for (const std::string& warning : list.warnings) read.warnings.push_back(file.string() + ": " + warning);
  return list;
}

/// Zero for points without standard deviations: they are held.
Eigen::Matrix3d covariance_of(const control::ControlPoint& p) {
  if (!p.sigma.allFinite()) return Eigen::Matrix3d::Zero();
  Eigen::Matrix3d correlation = Eigen::Matrix3d::Identity();
  correlation(0, 1) = correlation(1, 0) = p.correlation(0);
  correlation(0, 2) = correlation(2, 0) = p.correlation(1);
  correlation(1, 2) = correlation(2, 1) = p.correlation(2);
  return p.sigma.asDiagonal() * correlation * p.sigma.asDiagonal();
}

}  // namespace

void add_control(const std::filesystem::path& file, const std::vector<std::string>& check, ReadBlock& read) {
  PointBlock& block = read.block;
  std::map<std::string, int> index;
  for (size_t j = 0; j < block.points.size(); ++j) index.emplace(block.points[j].name, static_cast<int>(j));
  std::vector<Eigen::Vector3d> positions;
  std::vector<Eigen::Matrix3d> covariances;
  std::vector<std::string> unseen, labels_used, checks = check;
  std::set<int> taken;
  const control::ControlTable list = read_list(file, read);
  const bool numbered = std::any_of(list.points.begin(), list.points.end(),
                                    [&](const control::ControlPoint& p) { return index.count(p.name) > 0; });
  for (const control::ControlPoint& p : list.points) {
    auto point = index.find(p.name);
    // A name that is a number, too, would be taken for another point's number.
    const bool by_name = !p.second_name.empty() && (!numbered || !text::parse_number(p.second_name));
    if (point == index.end() && by_name) point = index.find(p.second_name);
    const std::string shown = p.second_name.empty() ? p.name : p.second_name;
    const auto is_check =
        std::find_if(checks.begin(), checks.end(), [&](const std::string& c) { return c == p.name || c == shown; });
    const bool to_check = is_check != checks.end() || p.check;
    if (is_check != checks.end()) checks.erase(is_check);
    if (point == index.end()) {
      unseen.push_back(shown);
      continue;
    }
    if (!taken.insert(point->second).second)
      throw std::runtime_error(file.string() + ": point " + p.name + " is listed a second time");
    block.control.points.push_back(point->second);
    labels_used.push_back(p.second_name.empty() ? p.name : p.name + " (" + p.second_name + ")");
    block.control.is_check.push_back(to_check);
    positions.push_back(p.position);
    covariances.push_back(covariance_of(p));
  }
  if (positions.empty())
    throw std::runtime_error(file.string() + ": none of its points (" + few_of(unseen) +
                             ") is measured in the block, by number or by name");
  if (!checks.empty()) throw std::runtime_error(file.string() + ": holds no check point " + few_of(checks));
  const auto& is_check = block.control.is_check;
  if (std::find(is_check.begin(), is_check.end(), false) == is_check.end())
    throw std::runtime_error(file.string() +
                             ": all of its points that are measured are check points: then nothing "
                             "brings the block into their frame; keep three or more of them as control");
  if (!unseen.empty()) {
    read.left_out.push_back("control " + few_of(unseen) +
                            ": measured in no image, or the block has no approximate coordinates of it");
    if (positions.size() < 3) read.contradictions.push_back(read.left_out.back());
  }
  const Eigen::Index size = 3 * static_cast<Eigen::Index>(positions.size());
  block.control.position.resize(size);
  block.control.covariance = Eigen::MatrixXd::Zero(size, size);
  for (size_t k = 0; k < positions.size(); ++k) {
    block.control.position.segment<3>(3 * static_cast<Eigen::Index>(k)) = positions[k];
    block.control.covariance.block<3, 3>(3 * static_cast<Eigen::Index>(k), 3 * static_cast<Eigen::Index>(k)) =
        covariances[k];
  }
  drop_strangers(read, labels_used);
}

}  // namespace plumbline::block
