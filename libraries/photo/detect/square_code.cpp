#include "photo/detect/square_code.hpp"

#include <apriltag/apriltag.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <bit>
#include <cmath>
#include <map>
#include <stdexcept>

#include "photo/detect/tag_family.hpp"

namespace plumbline::detect {
namespace {

/// Grey values of one colour over the tag: a plane, so that a gradient of the light does no harm.
class GreyPlane {
 public:
  void add(double x, double y, double value) {
    const Eigen::Vector3d row(x, y, 1);
    normal_ += row * row.transpose();
    right_ += row * value;
    ++count_;
    sum_ += value;
  }
  void solve() { plane_ = normal_.ldlt().solve(right_); }
  double at(double x, double y) const { return plane_.dot(Eigen::Vector3d(x, y, 1)); }
  double mean() const { return sum_ / count_; }

 private:
  Eigen::Matrix3d normal_ = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right_ = Eigen::Vector3d::Zero(), plane_ = Eigen::Vector3d::Zero();
  int count_ = 0;
  double sum_ = 0;
};

}  // namespace

Eigen::Matrix3d image_from_cells(const std::array<Eigen::Vector2d, 4>& c, int modules) {
  // From the unit square (Heckbert 1989, eq. 2.14), corners in the order (0,0), (1,0), (1,1), (0,1).
  const Eigen::Vector2d d1 = c[1] - c[2], d2 = c[3] - c[2], s = c[0] - c[1] + c[2] - c[3];
  const double determinant = d1.x() * d2.y() - d2.x() * d1.y();
  const double g = (s.x() * d2.y() - d2.x() * s.y()) / determinant;
  const double h = (d1.x() * s.y() - s.x() * d1.y()) / determinant;
  Eigen::Matrix3d m;
  m << c[1].x() - c[0].x() + g * c[1].x(), c[3].x() - c[0].x() + h * c[3].x(), c[0].x(),
      c[1].y() - c[0].y() + g * c[1].y(), c[3].y() - c[0].y() + h * c[3].y(), c[0].y(), g, h, 1;
  m.leftCols<2>() /= modules;
  return m;
}

SquareFamily apriltag_square_family(const std::string& name) {
  std::string base = name;
  const int border = take_border(base);
  const TagFamily source = make_tag_family(base);
  if (border > 1 && source->reversed_border)
    throw std::runtime_error("'" + name + "': " + base + " has no black border that could be two cells wide");
  SquareFamily family;
  family.name = name;
  family.border = border;
  family.modules = source->width_at_border + 2 * (border - 1);
  family.bright_inside = source->reversed_border;
  for (std::uint32_t i = 0; i < source->nbits; ++i)
    family.cells.push_back(
        {static_cast<int>(source->bit_x[i]) + border - 1, static_cast<int>(source->bit_y[i]) + border - 1});
  family.codes.assign(source->codes, source->codes + source->ncodes);
  for (std::uint32_t i = 0; i < source->ncodes; ++i) family.ids.push_back(static_cast<int>(i));
  family.correctable_bits = (static_cast<int>(source->h) - 1) / 2;
  return family;
}

SquareFamily dictionary_square_family(const TagDictionary& dictionary) {
  if (dictionary.size > 8)
    throw std::runtime_error(dictionary.name + " has markers of " + std::to_string(dictionary.size) + " x " +
                             std::to_string(dictionary.size) +
                             " cells; detect.tag_pyramid reads up to 8 x 8, detect.aruco more");
  SquareFamily family;
  family.name = dictionary.name;
  family.border = dictionary.border;
  family.modules = dictionary.size + 2 * dictionary.border;
  family.ids = dictionary.ids;
  family.correctable_bits = dictionary.correctable_bits;
  for (int row = 0; row < dictionary.size; ++row)
    for (int column = 0; column < dictionary.size; ++column)
      family.cells.push_back({dictionary.border + column, dictionary.border + row});
  for (const auto& cells : dictionary.codes) {
    std::uint64_t code = 0;
    for (const std::uint8_t cell : cells) code = code << 1 | cell;
    family.codes.push_back(code);
  }
  return family;
}

SquareFamily square_family(const std::string& name) {
  if (is_apriltag_family(name)) return apriltag_square_family(name);
  const TagDictionary dictionary = builtin_dictionary(name);
  return is_apriltag_family(dictionary.name) ? apriltag_square_family(dictionary.name)
                                             : dictionary_square_family(dictionary);
}

SquareDecoder::SquareDecoder(const SquareFamily& family, int max_hamming)
    : family_(family), max_hamming_(std::min(max_hamming, family.correctable_bits)) {
  const int last = family.modules - 1;
  std::map<std::array<int, 2>, std::size_t> index;
  for (std::size_t i = 0; i < family.cells.size(); ++i) index[family.cells[i]] = i;
  for (const auto& [x, y] : family.cells) {
    turned_[0].push_back(index.at({x, y}));
    turned_[1].push_back(index.at({last - y, x}));
    turned_[2].push_back(index.at({last - x, last - y}));
    turned_[3].push_back(index.at({y, last - x}));
    mirrored_.push_back(index.at({last - x, y}));
  }
  for (std::size_t i = 0; i < family.codes.size(); ++i) exact_.emplace(family.codes[i], static_cast<int>(i));
}

double chance_of_code(std::size_t codes, std::size_t bits, int corrected) {
  double words = 0, choices = 1;  // binomial coefficient of `bits` over k
  for (int k = 0; k <= corrected; ++k) {
    words += choices;
    choices *= static_cast<double>(bits - static_cast<std::size_t>(k)) / (k + 1);
  }
  return std::min(1.0, 4 * static_cast<double>(codes) * words * std::pow(0.5, static_cast<double>(bits)));
}

double SquareDecoder::chance() const {
  return chance_of_code(family_.codes.size(), family_.cells.size(), max_hamming_);
}

namespace {

/// The first of the codes that differs from `code` in at most `most` bits; their number if none does.
__attribute__((target_clones("popcnt", "default"))) std::size_t first_within(const std::vector<std::uint64_t>& codes,
                                                                             std::uint64_t code, int most) {
  std::size_t i = 0;
  while (i < codes.size() && std::popcount(code ^ codes[i]) > most) ++i;
  return i;
}

}  // namespace

std::optional<std::array<int, 2>> SquareDecoder::find(std::uint64_t code) const {
  if (const auto found = exact_.find(code); found != exact_.end()) return std::array<int, 2>{found->second, 0};
  if (max_hamming_ <= 0) return std::nullopt;
  const std::size_t i = first_within(family_.codes, code, max_hamming_);
  if (i == family_.codes.size()) return std::nullopt;
  return std::array<int, 2>{static_cast<int>(i), std::popcount(code ^ family_.codes[i])};
}

CodeReading SquareDecoder::read(const PixelRows& image, const std::array<Eigen::Vector2d, 4>& corners) const {
  constexpr double kAgree = 0.6;        // of the border's cells on their own side of the threshold
  constexpr double kOverexposed = 245;  // mean of white around the border [grey values]
  constexpr double kSharpening = 0.25;  // as libapriltag's decode_sharpening
  CodeReading result;
  const int n = family_.modules;
  const Eigen::Matrix3d to_image = image_from_cells(corners, n);
  const auto grey = [&](double column, double row, float& value) {
    const Eigen::Vector3d p = to_image * Eigen::Vector3d(column, row, 1);
    const double x = p.x() / p.z(), y = p.y() / p.z();
    if (!(p.z() > 0) || !image.holds(x, y)) return false;
    value = image.at(x, y);
    return true;
  };

  // The border, black from inside and white from outside (or the other way round).
  std::vector<std::array<double, 3>> inside, outside;
  for (int side = 0; side < 4; ++side)
    for (int i = 0; i < n; ++i)
      for (const double across : {0.5, -0.5}) {
        const double a = i + 0.5, b = side < 2 ? across : n - across;
        const double column = side % 2 == 0 ? a : b, row = side % 2 == 0 ? b : a;
        float value;
        if (grey(column, row, value))
          (across > 0 ? inside : outside).push_back({column, row, static_cast<double>(value)});
      }
  // A tag may be cut a little by the image's border.
  if (inside.size() < static_cast<std::size_t>(3 * n) || outside.size() < static_cast<std::size_t>(2 * n))
    return result;
  GreyPlane dark, bright;
  for (const auto& [x, y, value] : inside) (family_.bright_inside ? bright : dark).add(x, y, value);
  for (const auto& [x, y, value] : outside) (family_.bright_inside ? dark : bright).add(x, y, value);
  if (bright.mean() - dark.mean() < 10) return result;
  dark.solve(), bright.solve();
  const auto threshold = [&](double x, double y) { return 0.5 * (dark.at(x, y) + bright.at(x, y)); };
  for (const auto* border : {&inside, &outside}) {
    double right = 0;
    for (const auto& [x, y, value] : *border)
      right += (value > threshold(x, y)) == ((border == &inside) == family_.bright_inside);
    if (right < kAgree * static_cast<double>(border->size())) return result;
  }

  const auto above = [&](double column, double row) -> std::optional<double> {  // the threshold
    float value;
    if (!grey(column, row, value)) return std::nullopt;
    return static_cast<double>(value) - threshold(column, row);
  };
  std::vector<double> differences;  // in the mean over each cell
  for (const auto& [x, y] : family_.cells) {
    double difference = 0;
    for (const auto& [dx, dy] : {std::pair(0.0, 0.0), {-0.2, -0.2}, {0.2, -0.2}, {-0.2, 0.2}, {0.2, 0.2}}) {
      float value;
      if (!grey(x + 0.5 + dx, y + 0.5 + dy, value)) return result;
      difference += 0.2 * (static_cast<double>(value) - threshold(x + 0.5, y + 0.5));
    }
    differences.push_back(difference);
  }
  read_cells(differences, corners, result);
  if (result.code || bright.mean() < kOverexposed) return result;
  // White that is overexposed runs into single black cells: in their middle, against their neighbours, they are dark.
  for (std::size_t i = 0; i < differences.size(); ++i) {
    const double x = family_.cells[i][0] + 0.5, y = family_.cells[i][1] + 0.5;
    const double own = above(x, y).value_or(0);
    differences[i] = own;
    for (const auto& [dx, dy] : {std::pair(-1, 0), {1, 0}, {0, -1}, {0, 1}})
      if (const auto beside = above(x + dx, y + dy)) differences[i] += kSharpening * (own - *beside);
  }
  CodeReading again;
  read_cells(differences, corners, again);
  return again.code ? again : result;
}

/// The code of the cells, by how far each is above the threshold, or whether it is one in a mirror.
void SquareDecoder::read_cells(const std::vector<double>& above, const std::array<Eigen::Vector2d, 4>& corners,
                               CodeReading& result) const {
  std::uint64_t seen = 0;
  std::array<double, 2> margin = {}, count = {};
  for (const double difference : above) {
    const bool white = difference > 0;
    seen = seen << 1 | static_cast<std::uint64_t>(white);
    margin[white] += std::abs(difference);
    count[white] += 1;
  }
  const std::size_t bits = family_.cells.size();
  const auto in_order = [&](const std::vector<std::size_t>& order) {
    std::uint64_t code = 0;
    for (const std::size_t bit : order) code = code << 1 | (seen >> (bits - 1 - bit) & 1);
    return code;
  };
  for (int turn = 0; turn < 4; ++turn) {
    const auto found = find(in_order(turned_[turn]));
    if (!found || (result.code && result.code->hamming <= (*found)[1])) continue;
    ReadCode code;
    code.id = family_.ids[(*found)[0]];
    code.hamming = (*found)[1];
    code.decision_margin = std::min(count[0] > 0 ? margin[0] / count[0] : 0, count[1] > 0 ? margin[1] / count[1] : 0);
    // Clockwise from the upper left of the upright tag, as `turn` has it, to counter-clockwise from the lower left.
    for (int i = 0; i < 4; ++i) code.corners[i] = corners[(turn + 3 - i) % 4];
    result.code = code;
  }
  if (result.code) return;
  std::uint64_t flipped = in_order(mirrored_);
  for (int turn = 0; turn < 4 && !result.mirrored; ++turn) {
    result.mirrored = exact_.count(flipped) > 0;
    std::uint64_t next = 0;
    for (const std::size_t bit : turned_[1]) next = next << 1 | (flipped >> (bits - 1 - bit) & 1);
    flipped = next;
  }
}

}  // namespace plumbline::detect
