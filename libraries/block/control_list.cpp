#include "block/control_list.hpp"

#include <algorithm>
#include <cctype>
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

/// One point of the list.
struct Row {
  std::size_t line = 0;  ///< from 0
  std::string text;      ///< without its comment
  std::vector<std::string> words;
};

bool is_number(const std::string& word) { return formats::parse_number(word, '.').has_value(); }

/// Commas within numbers ("12,5") as points: where semicolons or blanks separate four words or more, and all commas
/// stand between two digits.
std::string with_decimal_points(std::string text) {
  if (words_of(text, false).size() < 4) return text;
  for (std::size_t at = text.find(','); at != std::string::npos; at = text.find(',', at + 1))
    if (at == 0 || at + 1 == text.size() || std::isdigit(static_cast<unsigned char>(text[at - 1])) == 0 ||
        std::isdigit(static_cast<unsigned char>(text[at + 1])) == 0)
      return text;
  std::replace(text.begin(), text.end(), ',', '.');
  return text;
}

/// A line of names of columns; 0 if it is none, else how many stand before that of X.
std::size_t columns_before_x(const std::string& line) {
  static const std::set<std::string> x = {"x", "x[m]", "x(m)", "e", "east", "easting", "rechts", "rechtswert"};
  const auto words = words_of(formats::to_lower(line), true);
  for (std::size_t i = 0; i < words.size() && i <= 2; ++i)
    if (x.count(words[i]) > 0) return words.size() >= i + 3 ? i : 0;
  return 0;
}

struct Rows {
  std::vector<Row> rows;
  std::size_t labels = 0;  ///< columns before X as a heading says it; 0 if none does
};

/// Lines with their comments taken off. A heading is a comment, or the first line if no word of it is a number.
Rows rows_of(const std::filesystem::path& file) {
  Rows result;
  const auto lines = lines_of(file);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const std::size_t comment = lines[i].find('#');
    Row row{i, with_decimal_points(lines[i].substr(0, comment)), {}};
    row.words = words_of(row.text, true);
    if (result.rows.empty() && row.words.empty() && comment != std::string::npos)
      result.labels = std::max(result.labels, columns_before_x(lines[i].substr(comment + 1)));
    if (row.words.empty()) continue;
    if (result.rows.empty() && std::none_of(row.words.begin(), row.words.end(), is_number) &&
        columns_before_x(row.text) > 0)
      result.labels = columns_before_x(row.text);
    else
      result.rows.push_back(std::move(row));
  }
  return result;
}

/// Five numbers are a number, coordinates and a standard deviation, or a number, a number as name and coordinates. A
/// heading tells; else names are numbers without a point in all lines, where not all coordinates are. Throws if nothing
/// tells.
bool fives_are_named(const std::filesystem::path& file, const Rows& list) {
  if (list.labels > 0) return list.labels == 2;
  const Row* undecided = nullptr;
  bool whole = true, fraction = false, only_last = true;
  for (const Row& row : list.rows) {
    if (row.words.size() != 5 || !std::all_of(row.words.begin() + 1, row.words.end(), is_number)) continue;
    undecided = &row;
    const auto has_point = [](const std::string& word) { return word.find('.') != std::string::npos; };
    whole = whole && row.words[1].find_first_not_of("0123456789") == std::string::npos;
    fraction = fraction || has_point(row.words[2]) || has_point(row.words[3]);
    only_last = only_last && has_point(row.words[4]);
  }
  if (undecided == nullptr || !whole || fraction) return whole;
  if (!only_last)
    throw std::runtime_error(file.string() + ":" + std::to_string(undecided->line + 1) + ": found '" + undecided->text +
                             "': is the second number a name or X? Say it in a comment at the head of the file, "
                             "'# id, name, X, Y, Z' or '# id, X, Y, Z, sigma'");
  return false;
}

/// How many words of a row stand before X; 0 if it cannot be read.
std::size_t labels_of(const Row& row, bool named) {
  const auto& words = row.words;
  std::size_t numbers = 0;  // from the right
  while (numbers < words.size() && is_number(words[words.size() - 1 - numbers])) ++numbers;
  std::size_t labels = 0;
  for (std::size_t l : {std::size_t{1}, std::size_t{2}}) {
    if (words.size() < l + 3) continue;
    const std::size_t rest = words.size() - l;
    if ((rest != 3 && rest != 4 && rest != 6) || numbers < rest) continue;
    if (labels == 0 || named || !is_number(words[1])) labels = l;
  }
  return labels;
}

}  // namespace

void add_control(const std::filesystem::path& file, const std::vector<std::string>& check, ReadBlock& read) {
  PointBlock& block = read.block;
  std::map<std::string, int> index;
  for (size_t j = 0; j < block.points.size(); ++j) index.emplace(block.points[j].name, static_cast<int>(j));
  std::vector<Eigen::Vector3d> positions, sigmas;
  std::vector<std::string> unseen, labels_used, checks = check;
  std::set<int> taken;
  const Rows list = rows_of(file);
  const bool named = fives_are_named(file, list);
  const bool numbered =
      std::any_of(list.rows.begin(), list.rows.end(), [&](const Row& row) { return index.count(row.words[0]) > 0; });
  for (const Row& row : list.rows) {
    const auto& words = row.words;
    const auto fail = [&](const std::string& what) {
      throw std::runtime_error(file.string() + ":" + std::to_string(row.line + 1) + ": " + what);
    };
    const std::size_t labels = labels_of(row, named);
    if (labels == 0)
      fail("found '" + row.text + "', expected id, name, X, Y, Z and perhaps three standard deviations [m]");
    std::vector<double> numbers;
    for (std::size_t i = labels; i < words.size(); ++i) numbers.push_back(*formats::parse_number(words[i], '.'));
    auto point = index.find(words[0]);
    // A name that is a number, too, would be taken for another point's number.
    const bool by_name = labels == 2 && (!numbered || !is_number(words[1]));
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
    block.control.covariance.diagonal().segment<3>(3 * static_cast<Eigen::Index>(k)) = sigmas[k].cwiseAbs2();
  }
  drop_strangers(read, labels_used);
}

}  // namespace plumbline::adjust
