// Joints between panels from the edges that photographs show.
#pragma once

#include "panels_node.hpp"
#include "photographs.hpp"

namespace plumbline::surface {

struct Joints : Node {
  static constexpr Info info{"surface.joints", "", 5,
                             "Width and flush step along the joints between panels, from edges in all photographs"};
  List<Image> images{"images", "the photographs"};
  In<Poses> poses{"poses", frame("frame=?F"), "their orientations, with the joint covariance of all"};
  In<Camera> camera{"camera", "the cameras that took them"};
  In<Surfaces> panels{"panels", frame("frame=?F"), "the panels, measured in the same photographs"};
  Param<double> station{"station", 0.02, "m", between(0.002, 1), "length along a joint of which the mean is taken"};
  Param<double> widest{
      "widest", 0.15, "m", between(0.001, 0.5),
      "wider joints of the design are not measured; up to 0.15 m they are named as not measured, up to "
      "0.5 m a warning says that there is a gap"};
  Param<double> search{"search", 0.012, "m", between(0.001, 0.2),
                       "how far an edge may be from where the design has it"};
  Param<int64_t> min_views{"min_views", 2, between(1, 20), "photographs that have to show an edge"};
  Param<double> edge_height_sigma{"edge_height_sigma", 3e-4, "m", between(1e-6, 0.01),
                                  "of an edge over its panel: bevels, dents"};
  Param<double> unmeasured_height_sigma{
      "unmeasured_height_sigma", 0.02, "m", between(1e-4, 0.5),
      "of an edge whose panel was not measured, from where the design has it: the photographs say where it is"};
  Param<double> memory{"memory", 1.5, "GiB", between(0.05, 64), "for the photographs' pixels"};
  Out<Surfaces> surfaces{"surfaces", frame("frame=?F"), "panels and joints"};
  Out<File> table{"table", "one line a joint, CSV"};

  void run(Context& context) override {
    SurfacesT result = panels.unpack();
    std::vector<ImageT> all;
    for (size_t i = 0; i < images.size(); ++i) all.push_back(images.unpack(i));
    const Photographs photographs(all, poses.unpack(), camera.unpack());
    const auto limit = static_cast<std::uint64_t>(*memory * 1073741824.0);
    context.reserve_memory(limit);
    PixelCache pixels(photographs, limit,
                      [&](size_t view) { return read_grey_image(context.resolve(photographs.uri(view))); });
    std::vector<PanelFace> faces;
    std::vector<PanelSurface> measured;
    for (const auto& panel : result.panels) {
      faces.push_back(face_of(*panel->face));
      measured.push_back(panel_of(*panel, result.rank));
    }
    const std::vector<Joint> joints = joints_of(faces, *widest);
    for (const std::string& words : words_of_pairs(faces, *widest)) context.warn(words);
    if (joints.empty())
      context.warn("no two panels are nearer than " + std::to_string(*widest) + " m: there are no joints");
    JointOptions options;
    options.station = *station, options.search = *search, options.min_views = static_cast<int>(*min_views);
    options.height_sigma = *edge_height_sigma, options.unmeasured_height_sigma = *unmeasured_height_sigma;
    int found = 0;
    std::vector<Eigen::RowVectorXd> by_orientation;
    for (size_t j = 0; j < joints.size(); ++j) {
      context.progress(static_cast<double>(j) / static_cast<double>(joints.size()), joints[j].a + " | " + joints[j].b);
      PanelFace strip{"", joints[j].plane, joints[j].width + 0.04, joints[j].length};
      std::vector<size_t> seen = photographs.that_see(strip, 0.01);
      std::uint64_t bytes = 0;
      size_t fit = 0;
      while (fit < seen.size() && bytes + photographs.bytes(seen[fit]) <= limit)
        bytes += photographs.bytes(seen[fit++]);
      if (fit < seen.size())
        context.warn("joint " + joints[j].a + " | " + joints[j].b + ": " + std::to_string(fit) + " of " +
                     std::to_string(seen.size()) + " photographs are used; 'memory' holds no more");
      seen.resize(fit);
      const MeasuredJoint joint =
          measure_joint(joints[j], faces, measured, pixels.take(seen), photographs.orientations(), options);
      if (!joint.not_measured.empty())
        context.warn("joint " + joints[j].a + " | " + joints[j].b + " is not measured: " + joint.not_measured);
      else if (joint.closed > 0)
        context.warn("joint " + joints[j].a + " | " + joints[j].b + ": at " + std::to_string(joint.closed) + " of " +
                     std::to_string(joint.stations_looked_at) +
                     " places along it no edges show: filled flush there, closed, or hidden by what stands before it");
      if (joint.covered > 0)
        context.warn("joint " + joints[j].a + " | " + joints[j].b + ": at " + std::to_string(joint.covered) + " of " +
                     std::to_string(joint.stations_looked_at) +
                     " places along it something stands before an edge (a tag's plate, a board): not measured there");
      found += joint.not_measured.empty();
      result.joints.push_back(describe(joint, joints[j]));
      for (const JointStation& at : joint.stations) by_orientation.push_back(at.width_by_orientation);
    }
    add_pairs_without_joint(faces, *widest, result);
    Eigen::MatrixXd rows(static_cast<Eigen::Index>(by_orientation.size()), photographs.orientations().size());
    for (Eigen::Index i = 0; i < rows.rows(); ++i) rows.row(i) = by_orientation[i];
    if (rows.rows() > 0) add_common_errors(reduced_factor(rows, photographs.orientations()), result);
    context.info(std::to_string(found) + " of " + std::to_string(joints.size()) + " joints measured");
    context.metric("joints", found, "1");
    surfaces.commit(result);
    table.commit(text_file("joints.csv", "text/csv", joints_table(result)));
  }
};

}  // namespace plumbline::surface
