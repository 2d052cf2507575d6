#include "photo/bundle/problem.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "plumbline/rigid_transform.hpp"

namespace plumbline::bundle {
namespace {

void require(bool holds, const std::string& what) {
  if (!holds) throw std::runtime_error("image block: " + what);
}

bool within(int index, size_t size) { return index >= 0 && static_cast<size_t>(index) < size; }

size_t count_of(const Problem& p, Kind kind) {
  switch (kind) {
    case Kind::image:
    case Kind::shift:
      return p.images.size();
    case Kind::point:
      return p.points.size();
    case Kind::plate:
    case Kind::form:
      return p.plates.size();
    case Kind::camera:
      return p.cameras.size();
    case Kind::mount:
      return p.mounts.size();
    case Kind::bend:
      return p.sheets.size();
    default:
      return p.batches.size();
  }
}

Eigen::Index coordinates_of(const Problem& p, Ref ref) {
  if (ref.kind == Kind::camera) return value_count(p.cameras[ref.index].lens);
  if (ref.kind == Kind::shift || ref.kind == Kind::bend) return 2;
  if (ref.kind == Kind::form) return form_count;
  return ref.kind == Kind::scale || ref.kind == Kind::inset ? 1 : 3;
}

int size_of(const Problem& p, Ref ref) {
  const size_t i = static_cast<size_t>(ref.index);
  switch (ref.kind) {
    case Kind::image:
      return p.images[i].fixed || p.images[i].exposure >= 0 ? 0 : 6;
    case Kind::point:
      return p.points[i].fixed ? 0 : 3;
    case Kind::plate:
      return 6;
    case Kind::camera:
      return static_cast<int>(std::count(p.cameras[i].free.begin(), p.cameras[i].free.end(), true));
    case Kind::scale:
      return p.batches[i].scale_free ? 1 : 0;
    case Kind::inset:
      return p.batches[i].inset_free ? 1 : 0;
    case Kind::shift:
      return p.images[i].shift_free ? 2 : 0;
    case Kind::form:
      return p.plates[i].form_end - p.plates[i].form_begin;
    case Kind::mount:
      return p.mounts[i].fixed ? 0 : 6;
    case Kind::bend:
      return p.sheets[i].bend_free ? 2 : 0;
  }
  return 0;
}

}  // namespace

int Problem::row_count() const {
  size_t rows = 2 * image_points.size() + 8 * image_tags.size() + distances.size();
  for (const auto& k : known) rows += static_cast<size_t>(k.whitening.rows());
  return static_cast<int>(rows);
}

void Problem::require_consistent() const {
  const auto check = [&](Ref ref) {
    require(within(ref.index, count_of(*this, ref.kind)), "an observation refers to a number out of range");
  };
  for (const auto& c : cameras)
    require(static_cast<int>(c.free.size()) == value_count(c.lens), "camera " + c.name + " does not fit its lens");
  for (const auto& i : images) {
    check({Kind::camera, i.camera});
    if (i.mount >= 0) check({Kind::mount, i.mount});
    if (i.exposure < 0) continue;
    check({Kind::image, i.exposure});
    require(images[i.exposure].exposure < 0, "an exposure's image has no pose of its own");
  }
  for (const auto& p : points) {
    if (p.sheet < 0) continue;
    check({Kind::bend, p.sheet});
    require(p.fixed, "point " + p.name + " of a sheet is not fixed");
  }
  for (const auto& p : plates) check({Kind::scale, p.batch});
  for (const auto& o : image_points) check({Kind::image, o.image}), check({Kind::point, o.point});
  for (const auto& o : image_tags) {
    check({Kind::image, o.image}), check({Kind::plate, o.plate});
    const Image& image = images[o.image];
    require(image.mount < 0 && image.exposure < 0, "tags in photographs of a rig are not computed");
    if (o.inset >= 0) check({Kind::inset, o.inset});
  }
  for (const auto& d : distances) {
    check(d.from), check(d.to);
    require(d.sigma > 0, "the distance '" + d.name + "' has no standard deviation");
  }
  for (const auto& k : known) {
    Eigen::Index columns = 0;
    for (Ref ref : k.refs) check(ref), columns += coordinates_of(*this, ref);
    if (k.world_from_plate) {
      require(k.refs.size() == 1 && k.refs[0].kind == Kind::plate, "a known rotation is that of a single plate");
      columns += 3;
    }
    require(k.whitening.cols() == columns && k.target.size() == columns, "known values and their weights do not fit");
  }
}

Layout::Layout(const Problem& problem) {
  offsets_.push_back(0);
  for (int k = 0; k < kind_count; ++k) {
    const Kind kind = static_cast<Kind>(k);
    first_[k] = static_cast<int>(sizes_.size());
    for (int i = 0; i < static_cast<int>(count_of(problem, kind)); ++i) {
      sizes_.push_back(size_of(problem, {kind, i}));
      offsets_.push_back(offsets_.back() + sizes_.back());
    }
  }
  first_[kind_count] = static_cast<int>(sizes_.size());
  for (const auto& camera : problem.cameras) {
    free_values_.emplace_back();
    for (size_t i = 0; i < camera.free.size(); ++i)
      if (camera.free[i]) free_values_.back().push_back(static_cast<int>(i));
  }
}

Ref Layout::ref(int block) const {
  int kind = 0;
  while (block >= first_[static_cast<size_t>(kind) + 1]) ++kind;
  return {static_cast<Kind>(kind), block - first_[kind]};
}

Eigen::Vector3d turn_between(const Eigen::Quaterniond& from, const Eigen::Quaterniond& to) {
  Eigen::Quaterniond q = to * from.conjugate();
  if (q.w() < 0) q.coeffs() = -q.coeffs();
  const double sine = q.vec().norm();
  return sine < 1e-300 ? Eigen::Vector3d(2 * q.vec()) : Eigen::Vector3d(2 * std::atan2(sine, q.w()) / sine * q.vec());
}

void apply_step(const Problem& problem, const Layout& layout, const Eigen::VectorXd& step, State& state) {
  const auto at = [&](Kind kind, size_t i) { return layout.offset(layout.block({kind, static_cast<int>(i)})); };
  const auto place = [&](Placement& p, int offset) {
    p.set(quaternion_from_rotation_vector(step.segment<3>(offset + 3)) * p.rotation,
          p.position + step.segment<3>(offset));
  };
  for (size_t i = 0; i < problem.images.size(); ++i)
    if (size_of(problem, {Kind::image, static_cast<int>(i)}) > 0) place(state.images[i], at(Kind::image, i));
  for (size_t i = 0; i < problem.mounts.size(); ++i)
    if (!problem.mounts[i].fixed) place(state.mounts[i], at(Kind::mount, i));
  for (size_t i = 0; i < problem.sheets.size(); ++i)
    if (problem.sheets[i].bend_free) state.bends[i] += step.segment<2>(at(Kind::bend, i));
  for (size_t i = 0; i < problem.points.size(); ++i)
    if (!problem.points[i].fixed) state.points[i] += step.segment<3>(at(Kind::point, i));
  for (size_t i = 0; i < problem.plates.size(); ++i) place(state.plates[i], at(Kind::plate, i));
  for (size_t i = 0; i < problem.cameras.size(); ++i) {
    int offset = at(Kind::camera, i);
    for (int value : layout.free_values(static_cast<int>(i))) state.interiors[i][value] += step(offset++);
  }
  for (size_t i = 0; i < problem.images.size(); ++i)
    if (problem.images[i].shift_free) state.shifts[i] += step.segment<2>(at(Kind::shift, i));
  for (size_t i = 0; i < problem.plates.size(); ++i)
    for (int k = problem.plates[i].form_begin, offset = at(Kind::form, i); k < problem.plates[i].form_end; ++k)
      state.forms[i][k] += step(offset++);
  for (size_t i = 0; i < problem.batches.size(); ++i) {
    if (problem.batches[i].scale_free) state.scales[i] += step(at(Kind::scale, i));
    if (problem.batches[i].inset_free) state.insets[i] += step(at(Kind::inset, i));
  }
}

std::string name_of_unknown(const Problem& problem, const Layout& layout, int unknown) {
  int block = 0;
  while (block + 1 < layout.block_count() && layout.offset(block + 1) <= unknown) ++block;
  const Ref ref = layout.ref(block);
  const int c = unknown - layout.offset(block);
  const size_t i = static_cast<size_t>(ref.index);
  const char* axes[] = {"x", "y", "z"};
  switch (ref.kind) {
    case Kind::image:
      return std::string(c < 3 ? "projection centre " : "rotation ") + axes[c % 3] + " of image " +
             problem.images[i].name;
    case Kind::point:
      return std::string(axes[c % 3]) + " of point " + problem.points[i].name;
    case Kind::plate:
      return c < 3 ? problem.plates[i].name + " " + axes[c]
                   : problem.plates[i].name + " plate rotation " + std::string(axes[c - 3]);
    case Kind::camera:
      return "interior orientation " + value_names(problem.cameras[i].lens)[layout.free_values(ref.index)[c]] +
             (problem.cameras.size() > 1 ? " of camera " + problem.cameras[i].name : "");
    case Kind::scale:
      return "tag scale of batch '" + problem.batches[i].name + "'";
    case Kind::inset:
      return "corner inset of batch '" + problem.batches[i].name + "'";
    case Kind::shift:
      return std::string("principal point ") + axes[c] + " of image " + problem.images[i].name;
    case Kind::form:
      return "form of " + problem.plates[i].name;
    case Kind::mount:
      return std::string(c < 3 ? "place in the rig of " : "rotation in the rig of ") + problem.mounts[i].name;
    case Kind::bend:
      return "bend of " + problem.sheets[i].name + " in " + axes[c];
  }
  return "?";
}

}  // namespace plumbline::bundle
