// GNSS vectors in a file of STAR*NET: G0 a description, G1 the differences in X, Y, Z of the earth, G2 and G3 their
// covariance.
#include <Eigen/Cholesky>

#include "survey/files/starnet_reader.hpp"

namespace plumbline::survey {

// .GPS WEIGHT COVARIANCE or STDERRCORREL; .GPS FACTOR horizontal [VERT vertical], on standard deviations.
void StarNetReader::read_gps_option(const Parts& parts) {
  const auto word = [&](std::size_t i) { return i < parts.size() ? text::to_lower(parts[i]) : std::string(); };
  if (word(1) == "weight" && parts.size() == 3 && (word(2) == "covariance" || word(2) == "stderrcorrel")) {
    gps_correlations_ = word(2) == "stderrcorrel";
    return;
  }
  const auto horizontal = word(1) == "factor" && parts.size() > 2 ? text::parse_number(parts[2]) : std::nullopt;
  const auto vertical = parts.size() == 5 && word(3) == "vert" ? text::parse_number(parts[4]) : horizontal;
  if (!horizontal || !vertical || *horizontal <= 0 || *vertical <= 0 || (parts.size() != 3 && parts.size() != 5))
    return reject(line_text_,
                  ".GPS WEIGHT COVARIANCE or STDERRCORREL, or .GPS FACTOR and one number, or two with VERT");
  gps_horizontal_ = *horizontal;
  gps_vertical_ = *vertical;
}

void StarNetReader::read_vector(std::string_view code, const Parts& parts) {
  if (code == "G0" || code == "G1") finish_vector();
  if (code == "G0") return;
  if (metres_ != 1)
    return reject(parts[0],
                  "a job in metres: whether vectors are in its units or in metres, as receivers give them, nobody says "
                  "here; put '.UNITS Meters' before them and the job's units behind them if they are in metres");
  std::vector<std::string> ids;
  if (code == "G1" && (parts.size() < 2 || !names(parts[1], 2, ids))) return;
  const std::size_t first = code == "G1" ? 2 : 1;
  Eigen::Vector3d values;
  for (std::size_t k = 0; k < 3; ++k) {
    const auto value = first + k < parts.size() ? text::parse_number(parts[first + k]) : std::nullopt;
    if (!value) return reject(line_text_, "three numbers behind " + std::string(code));
    values[static_cast<Eigen::Index>(k)] = *value;
  }
  if (!ends_at(parts, first + 3, "G1, G2 and G3 have three numbers")) return;
  if (code == "G1") {
    if (ids[0] == ids[1]) return reject(parts[1], "two stations");
    VectorGroup& g = vector_.emplace();
    g.is_geocentric = true;
    g.horizontal_factor = gps_horizontal_;
    g.vertical_factor = gps_vertical_;
    g.vectors = {{ids[0], ids[1]}};
    g.values = metres_ * values;
    g.source = builder_.at(line_, 1);
    return;
  }
  if (!vector_) return reject(parts[0], "G1 with the vector before it");
  Eigen::MatrixXd& c = vector_->covariance;
  if (code == "G2") {
    if (gps_correlations_) values = values.cwiseAbs2().eval();
    c = Eigen::MatrixXd(metres_ * metres_ * values.asDiagonal().toDenseMatrix());
    return;
  }
  if (c.size() == 0) return reject(parts[0], "G2 before G3");
  constexpr int pairs[3][2] = {{0, 1}, {0, 2}, {1, 2}};
  for (int k = 0; k < 3; ++k) {
    const auto [i, j] = pairs[k];
    c(i, j) = c(j, i) = gps_correlations_ ? values[k] * std::sqrt(c(i, i) * c(j, j)) : metres_ * metres_ * values[k];
  }
}

void StarNetReader::finish_vector() {
  if (!vector_) return;
  const VectorGroup g = std::move(*vector_);
  vector_.reset();
  const bool usable = g.covariance.size() > 0 && g.covariance.diagonal().minCoeff() > 0 &&
                      Eigen::LLT<Eigen::MatrixXd>(g.covariance).info() == Eigen::Success;
  if (!usable)
    return builder_.skip(g.source.line, 1, "G1 " + g.vectors[0].from + "-" + g.vectors[0].to,
                         "G2 and G3 behind it, which make a positive definite covariance");
  for (const std::string& id : {g.vectors[0].from, g.vectors[0].to}) builder_.point(id, g.source);
  builder_.survey.vectors.push_back(g);
}

}  // namespace plumbline::survey
