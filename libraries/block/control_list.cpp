#include "block/control_list.hpp"

#include <algorithm>
#include <map>
#include <set>
#include <stdexcept>

#include "block/block_text.hpp"
#include "block/control_words.hpp"
#include "text/text.hpp"

namespace plumbline::adjust {
namespace {

/// Leaves out control that is another point than the block's of that number, by its distances to the others.
void drop_strangers(ReadBlock& read, const std::vector<std::string>& labels) {
  PointBlock& block = read.block;
  BlockControl& control = block.control;
  std::vector<Eigen::Vector3d> in_block, in_control;
  for (size_t k = 0; k < control.points.size(); ++k) {
    in_block.push_back(block.points[static_cast<size_t>(control.points[k])].position);
    in_control.emplace_back(control.position.segment<3>(3 * static_cast<Eigen::Index>(k)));
  }
  const std::vector<size_t> strangers = strangers_in_figure(in_block, in_control);
  if (strangers.empty()) return;
  std::vector<std::string> names;
  BlockControl kept;
  std::vector<Eigen::Index> rows;
  for (size_t k = 0; k < control.points.size(); ++k) {
    if (std::find(strangers.begin(), strangers.end(), k) != strangers.end()) {
      names.push_back(labels[k]);
      continue;
    }
    kept.points.push_back(control.points[k]);
    kept.is_check.push_back(control.is_check[k]);
    for (Eigen::Index c = 0; c < 3; ++c) rows.push_back(3 * static_cast<Eigen::Index>(k) + c);
  }
  kept.position = control.position(rows);
  kept.covariance = control.covariance(rows, rows);
  control = kept;
  read.left_out.push_back("control " + few_of(names) +
                          ": other points in the block than in the list, by most of their distances to the rest of the "
                          "control; number the list as the block is");
  read.contradictions.push_back(read.left_out.back());
}

}  // namespace

void add_control(const std::filesystem::path& file, const std::vector<std::string>& check, ReadBlock& read) {
  PointBlock& block = read.block;
  std::map<std::string, int> index;
  for (size_t j = 0; j < block.points.size(); ++j) index.emplace(block.points[j].name, static_cast<int>(j));
  std::vector<Eigen::Vector3d> positions, sigmas;
  std::vector<std::string> unseen, labels_used, checks = check;
  std::set<int> taken;
  const auto lines = lines_of(file);
  const auto by_number = [&](const std::string& line) {
    const auto words = words_of(line.substr(0, line.find('#')), true);
    return !words.empty() && index.count(words[0]) > 0;
  };
  // Five numbers are a number, coordinates and a standard deviation, or a number and a name: a comment above them
  // tells.
  const bool named = std::any_of(lines.begin(), lines.end(), [](const std::string& line) {
    const size_t comment = line.find('#');
    return comment != std::string::npos && formats::to_lower(line.substr(comment)).find("name") != std::string::npos;
  });
  const bool numbered = std::any_of(lines.begin(), lines.end(), by_number);
  for (size_t i = 0; i < lines.size(); ++i) {
    const std::string text = lines[i].substr(0, lines[i].find('#'));
    const auto words = words_of(text, true);
    if (words.empty()) continue;
    const auto fail = [&](const std::string& what) {
      throw std::runtime_error(file.string() + ":" + std::to_string(i + 1) + ": " + what);
    };
    std::vector<double> numbers;  // from the right: coordinates and standard deviations
    for (auto w = words.rbegin(); w != words.rend() && numbers.size() < 7; ++w) {
      const auto value = formats::parse_number(*w, '.');
      if (!value) break;
      numbers.insert(numbers.begin(), *value);
    }
    // id [name] X Y Z [sx sy sz]: what is left of three or six numbers is id and name.
    size_t labels = 0;
    for (size_t l : {size_t{1}, size_t{2}})
      if (words.size() >= l + 3 && (words.size() - l == 3 || words.size() - l == 6 || words.size() - l == 4) &&
          numbers.size() >= words.size() - l)
        labels = labels == 0 || named || !formats::parse_number(words[1], '.') ? l : labels;
    if (labels == 0) fail("found '" + text + "', expected id, name, X, Y, Z and perhaps three standard deviations [m]");
    numbers.erase(numbers.begin(), numbers.end() - static_cast<long>(words.size() - labels));
    auto point = index.find(words[0]);
    // A name that is a number, too, would be taken for another point's number.
    const bool by_name = labels == 2 && (!numbered || !formats::parse_number(words[1], '.'));
    if (point == index.end() && by_name) point = index.find(words[1]);
    const std::string shown = labels == 2 ? words[1] : words[0];
    const auto is_check =
        std::find_if(checks.begin(), checks.end(), [&](const std::string& c) { return c == words[0] || c == shown; });
    const bool to_check = is_check != checks.end();
    if (to_check) checks.erase(is_check);
    if (point == index.end()) {
      unseen.push_back(shown);
      continue;
    }
    if (!taken.insert(point->second).second) fail("point " + words[0] + " is listed a second time");
    Eigen::Vector3d sigma = Eigen::Vector3d::Zero();
    if (numbers.size() == 6) sigma = {numbers[3], numbers[4], numbers[5]};
    if (numbers.size() == 4) sigma.setConstant(numbers[3]);
    if (!(sigma.minCoeff() >= 0)) fail("a standard deviation is negative");
    block.control.points.push_back(point->second);
    labels_used.push_back(labels == 2 ? words[0] + " (" + words[1] + ")" : words[0]);
    block.control.is_check.push_back(to_check);
    positions.push_back({numbers[0], numbers[1], numbers[2]});
    sigmas.push_back(sigma);
  }
  if (positions.empty())
    throw std::runtime_error(file.string() + ": none of its points (" + few_of(unseen) +
                             ") is measured in the block, by number or by name");
  if (!checks.empty()) throw std::runtime_error(file.string() + ": holds no check point " + few_of(checks));
  if (!unseen.empty()) read.left_out.push_back("control " + few_of(unseen) + ": measured in no image");
  const Eigen::Index size = 3 * static_cast<Eigen::Index>(positions.size());
  block.control.position.resize(size);
  block.control.covariance = Eigen::MatrixXd::Zero(size, size);
  for (size_t k = 0; k < positions.size(); ++k) {
    block.control.position.segment<3>(3 * static_cast<Eigen::Index>(k)) = positions[k];
    block.control.covariance.diagonal().segment<3>(3 * static_cast<Eigen::Index>(k)) = sigmas[k].cwiseAbs2();
  }
  drop_strangers(read, labels_used);
}

}  // namespace plumbline::adjust
