// What of an elimination follows from the problem alone: who goes, who stays, and where everything stands.
#include <algorithm>
#include <cmath>

#include "photo/bundle/elimination.hpp"
#include "plumbline/stop.hpp"

namespace plumbline::bundle {
namespace {

bool is_shared(Kind kind) {
  return kind == Kind::camera || kind == Kind::scale || kind == Kind::inset || kind == Kind::shift ||
         kind == Kind::form || kind == Kind::mount || kind == Kind::bend;
}

}  // namespace

Elimination::Elimination(const Problem& problem, const Layout& layout, Side side, int threads, Reduced reduced)
    : problem_(problem), layout_(layout), threads_(threads), how_(reduced), factor_(nullptr) {
  choose_side(side);
  sort_unknowns();
  sort_terms();
  lay_out_y();
  prepare_known();
  couple_kept();
}

void Elimination::choose_side(Side side) {
  tied_.assign(static_cast<size_t>(layout_.block_count()), false);
  for (const auto& d : problem_.distances)
    for (Ref ref : {d.from, d.to}) tied_[layout_.block(ref)] = true;
  for (const auto& k : problem_.known)
    if (k.refs.size() > 1)
      for (Ref ref : k.refs) tied_[layout_.block(ref)] = true;
  bool images_tied = false;
  for (size_t i = 0; i < problem_.images.size(); ++i)
    images_tied = images_tied || tied_[layout_.block({Kind::image, static_cast<int>(i)})];
  if (side != Side::automatic) {
    side_ = side;
    return;
  }
  // Multiplications of the elimination and of the factorisation, roughly.
  std::vector<double> seen_by_image(problem_.images.size()), seen_by_point(problem_.points.size()),
      seen_by_plate(problem_.plates.size());
  for (const auto& o : problem_.image_points) seen_by_image[o.image] += 3, seen_by_point[o.point] += 6;
  for (const auto& o : problem_.image_tags) seen_by_image[o.image] += 6, seen_by_plate[o.plate] += 6;
  double body_size = 0, image_size = 6 * static_cast<double>(problem_.images.size()), by_body = 0, by_image = 0;
  for (double s : seen_by_image) by_image += 3 * s * s;
  for (size_t j = 0; j < seen_by_point.size(); ++j) {
    body_size += 3;
    if (tied_[layout_.block({Kind::point, static_cast<int>(j)})])
      image_size += 3;
    else
      by_body += 1.5 * seen_by_point[j] * seen_by_point[j];
  }
  for (size_t j = 0; j < seen_by_plate.size(); ++j) {
    body_size += 6;
    if (tied_[layout_.block({Kind::plate, static_cast<int>(j)})])
      image_size += 6;
    else
      by_body += 3 * seen_by_plate[j] * seen_by_plate[j];
  }
  by_body += std::pow(image_size, 3) / 6;
  by_image += std::pow(body_size, 3) / 6;
  side_ = by_image < by_body && !images_tied ? Side::images : Side::bodies;
}

void Elimination::sort_unknowns() {
  const int count = layout_.block_count();
  eliminated_.assign(static_cast<size_t>(count), -1);
  kept_offset_.assign(static_cast<size_t>(count), -1);
  kept_index_.assign(static_cast<size_t>(count), -1);
  std::vector<int> shared;
  for (int b = 0; b < count; ++b) {
    stop_point();
    if (layout_.size(b) == 0) continue;
    const Kind kind = layout_.ref(b).kind;
    const bool body = kind == Kind::point || kind == Kind::plate;
    const bool goes = side_ == Side::bodies ? body && !tied_[b] : kind == Kind::image;
    if (goes) {
      eliminated_[b] = static_cast<int>(blocks_.size());
      blocks_.emplace_back();
      blocks_.back().block = b;
      blocks_.back().size = layout_.size(b);
    } else {
      (is_shared(kind) ? shared : kept_blocks_).push_back(b);
    }
  }
  kept_blocks_.insert(kept_blocks_.end(), shared.begin(), shared.end());
  for (size_t k = 0; k < kept_blocks_.size(); ++k) {
    const size_t b = static_cast<size_t>(kept_blocks_[k]);
    kept_index_[b] = static_cast<int>(k);
    kept_offset_[b] = kept_count_;
    kept_count_ += layout_.size(kept_blocks_[k]);
  }
}

/// In the order of Rows' parts.
void Elimination::blocks_of(const TermRef& term, std::vector<int>& all) const {
  all.clear();
  const size_t i = static_cast<size_t>(term.index);
  if (term.kind == TermRef::Kind::point) {
    const ImagePoint& o = problem_.image_points[i];
    const Image& image = problem_.images[o.image];
    const int sheet = problem_.points[o.point].sheet;
    all = {layout_.block({Kind::image, problem_.pose_of(o.image)}), layout_.block({Kind::camera, image.camera}),
           layout_.block({Kind::shift, o.image})};
    if (image.mount >= 0) all.push_back(layout_.block({Kind::mount, image.mount}));
    if (sheet >= 0) all.push_back(layout_.block({Kind::bend, sheet}));
    all.push_back(layout_.block({Kind::point, o.point}));
  } else if (term.kind == TermRef::Kind::tag) {
    const ImageTag& o = problem_.image_tags[i];
    const int batch = problem_.plates[o.plate].batch;
    all = {layout_.block({Kind::image, o.image}),
           layout_.block({Kind::camera, problem_.images[o.image].camera}),
           layout_.block({Kind::shift, o.image}),
           layout_.block({Kind::scale, batch}),
           layout_.block({Kind::inset, o.inset < 0 ? batch : o.inset}),
           layout_.block({Kind::form, o.plate}),
           layout_.block({Kind::plate, o.plate})};
  } else if (term.kind == TermRef::Kind::distance) {
    all = {layout_.block(problem_.distances[i].from), layout_.block(problem_.distances[i].to)};
  } else {
    for (Ref ref : problem_.known[i].refs) all.push_back(layout_.block(ref));
  }
  std::erase_if(all, [&](int b) { return layout_.size(b) == 0; });
}

void Elimination::sort_terms() {
  terms_.resize(blocks_.size());
  std::vector<int> all;
  const auto add = [&](TermRef::Kind kind, size_t count) {
    for (size_t i = 0; i < count; ++i) {
      stop_point();
      const TermRef term{kind, static_cast<int>(i), {}};
      blocks_of(term, all);
      const auto goes = std::find_if(all.begin(), all.end(), [&](int b) { return eliminated(b) >= 0; });
      if (goes == all.end()) {
        loose_.push_back(term);
        continue;
      }
      terms_[eliminated(*goes)].push_back(term);
      auto& kept = blocks_[eliminated(*goes)].kept;
      for (int b : all)
        if (b != *goes) kept.push_back(b);
    }
  };
  add(TermRef::Kind::point, problem_.image_points.size());
  add(TermRef::Kind::tag, problem_.image_tags.size());
  add(TermRef::Kind::distance, problem_.distances.size());
  add(TermRef::Kind::known, problem_.known.size());
}

void Elimination::lay_out_y() {
  std::vector<int> all;
  size_t y = 0;
  for (size_t e = 0; e < blocks_.size(); ++e) {
    stop_point();
    Block& block = blocks_[e];
    std::sort(block.kept.begin(), block.kept.end(), [&](int a, int b) { return kept_offset(a) < kept_offset(b); });
    block.kept.erase(std::unique(block.kept.begin(), block.kept.end()), block.kept.end());
    block.y = y;
    block.first_run = static_cast<int>(runs_.size());
    for (size_t k = 0; k < block.kept.size(); ++k) {
      const int offset = kept_offset(block.kept[k]), size = layout_.size(block.kept[k]);
      if (block.run_count > 0 && runs_.back().offset + runs_.back().length == offset)
        runs_.back().length += size;
      else
        runs_.push_back({block.columns, offset, size}), ++block.run_count;
      block.local.push_back(block.columns);
      block.columns += size;
    }
    y += static_cast<size_t>(block.size) * (static_cast<size_t>(block.columns) + 1);
    for (auto& term : terms_[e]) {
      size_t next = 0;
      blocks_of(term, all);
      for (int b : all) {
        if (b == block.block) continue;
        const auto at = std::lower_bound(block.kept.begin(), block.kept.end(), b,
                                         [&](int p, int q) { return kept_offset(p) < kept_offset(q); });
        term.local[next++] = block.local[at - block.kept.begin()];
      }
    }
  }
  y_count_ = y;
}

std::string Elimination::name(const TermRef& term) const {
  const size_t i = static_cast<size_t>(term.index);
  if (term.kind == TermRef::Kind::point) {
    const auto& o = problem_.image_points[i];
    return "point " + problem_.points[o.point].name + " in image " + problem_.images[o.image].name;
  }
  if (term.kind == TermRef::Kind::tag) {
    const auto& o = problem_.image_tags[i];
    return "the tag of " + problem_.plates[o.plate].name + " in image " + problem_.images[o.image].name;
  }
  return "the distance '" + problem_.distances[i].name + "'";
}

void Elimination::prepare_known() {
  for (const Known& term : problem_.known) {
    Linear& known = known_.emplace_back();
    known.whitening = term.whitening / problem_.groups[term.group].sigma_factor;
    std::vector<int> chosen;
    linear_columns(problem_, layout_, term, chosen, known.columns);
    known.jacobian = known.whitening(Eigen::all, chosen);
    known.diagonal = known.jacobian.rows() == known.jacobian.cols() && known.jacobian.isDiagonal(0);
    if (known.diagonal)
      known.normal = known.jacobian.diagonal().cwiseAbs2().asDiagonal();
    else
      known.normal = known.jacobian.transpose() * known.jacobian;
    for (size_t c = 0; c < known.columns.size(); ++c)
      for (Ref ref : term.refs) {
        const int b = layout_.block(ref), within = known.columns[c] - layout_.offset(b);
        if (within < 0 || within >= layout_.size(b)) continue;
        const bool goes_on =
            !known.parts.empty() && known.parts.back().kept == kept_index(b) && known.at.back() + 1 == within;
        known.at.push_back(within);
        if (goes_on)
          ++known.parts.back().count;
        else
          known.parts.push_back({kept_index(b), static_cast<int>(c), 1});
        break;
      }
  }
}

/// Which kept blocks meet: in an observation, or through an eliminated block.
void Elimination::couple_kept() {
  std::vector<int> sizes, all, indices;
  for (int b : kept_blocks_) sizes.push_back(layout_.size(b));
  least_squares::Pattern direct(sizes), reduced(sizes);
  const auto couple = [&](const std::vector<int>& blocks, least_squares::Pattern& pattern) {
    indices.clear();
    for (int b : blocks)
      if (kept_index(b) >= 0) indices.push_back(kept_index(b));
    pattern.couple(indices);
  };
  for (size_t e = 0; e < blocks_.size(); ++e) {
    stop_point();
    if (e == 0 || blocks_[e].kept != blocks_[e - 1].kept) couple(blocks_[e].kept, reduced);
    for (const TermRef& term : terms_[e]) blocks_of(term, all), couple(all, direct);
  }
  for (const TermRef& term : loose_) blocks_of(term, all), couple(all, reduced);
  direct_pattern_ = std::move(direct);
  pattern_ = std::move(reduced);
  if (how_ == Reduced::factor)
    factor_ = least_squares::SparseCholesky(std::make_shared<const least_squares::Analysis>(pattern_));
}

std::size_t Elimination::bytes() const {
  std::size_t coupled = 0;
  for (const Block& block : blocks_) coupled += block.kept.size();
  const std::size_t matrices = sizeof(double) * y_count_ + sizeof(Coupled) * coupled +
                               least_squares::SymmetricBlocks::bytes(pattern_) +
                               (max_chunks + 1) * least_squares::SymmetricBlocks::bytes(direct_pattern_);
  if (how_ == Reduced::gradients) return matrices + 16 * sizeof(double) * static_cast<std::size_t>(kept_count_);
  const least_squares::Analysis& analysis = factor_.analysis();
  return matrices + 2 * analysis.bytes() + analysis.work_bytes();
}

/// The numbers, once they are wanted.
void Elimination::allocate() {
  if (is_allocated_) return;
  is_allocated_ = true;
  direct_ = least_squares::SymmetricBlocks(direct_pattern_);
  normal_ = least_squares::SymmetricBlocks(pattern_);
  y_.reserve(y_count_);
  for (constexpr size_t portion = size_t{1} << 22;
       y_.size() < y_count_;) {  // the system brings pages as they are touched
    stop_point();
    y_.resize(std::min(y_count_, y_.size() + portion));
  }
  coupled_.resize(layout_.block_count());
  for (const Block& block : blocks_) {
    stop_point();
    for (size_t k = 0; k < block.kept.size(); ++k)
      coupled_[block.kept[k]].push_back(
          {y_of(block), runs(block), block.run_count, block.size, block.columns, block.local[k]});
  }
}

}  // namespace plumbline::bundle
