// simulate.facade: photographs of a facade of panels, their orientations with errors of a known joint covariance, the
// design, and the truth beside them; simulate.scan: what a scanner sees of it.
#include <fmt/core.h>

#include <Eigen/Cholesky>
#include <filesystem>
#include <limits>

#include "artifacts/camera.hpp"
#include "artifacts/design.hpp"
#include "artifacts/file.hpp"
#include "artifacts/folder.hpp"
#include "artifacts/image.hpp"
#include "artifacts/poses.hpp"
#include "geometry/packed_symmetric.hpp"
#include "geometry/random.hpp"
#include "panelled_facade.hpp"
#include "planted_surfaces.hpp"
#include "plumbline/node.hpp"
#include "scan_node.hpp"

namespace {

using namespace plumbline;
using simulate::PanelledFacade;
using simulate::RaisedPanel;
using simulate::Skin;

constexpr double kThickness = 0.05;  // of a panel [m]

struct SimulateFacade : Node {
  static constexpr Info info{
      "simulate.facade", "", 2,
      "Simulates a facade of panels with planted relief: photographs, orientations that err, the design"};
  Param<int64_t> columns{"columns", 3, between(1, 40), "panels beside each other"};
  Param<int64_t> rows{"rows", 2, between(1, 40), "panels above each other"};
  Param<double> panel_width{"panel_width", 0.9, "m", between(0.1, 10), "of the design"};
  Param<double> panel_height{"panel_height", 0.7, "m", between(0.1, 10), "of the design"};
  Param<double> joint{"joint", 0.012, "m", between(0.002, 0.05), "width of the joints in the design"};
  Param<double> azimuth{"azimuth", 3.6, "rad", between(-7, 7), "direction out of the facade, clockwise from north (y)"};
  Param<int64_t> facades{"facades", 1, between(1, 4),
                         "of a block, each as large, with panels and photographs of its own, the next one to the right "
                         "around the corner"};
  Param<double> offset_sigma{"offset_sigma", 0.0015, "m", between(0, 0.05), "of panels out of the design's face"};
  Param<double> tilt_sigma{"tilt_sigma", 0.001, "rad", between(0, 0.05), "of panels, each way"};
  Param<double> bow_sigma{"bow_sigma", 0.0015, "m", between(0, 0.05),
                          "of the middle of panels over their edges, each way"};
  Param<double> place_sigma{"place_sigma", 0.0008, "m", between(0, 0.02),
                            "of panels along the facade: joints vary by it"};
  Param<int64_t> plain{"plain", 0, between(0, 100),
                       "panels painted so that nothing on them can be measured: the last ones"};
  Param<int64_t> glass{"glass", 0, between(0, 100), "panels that mirror: the ones before those"};
  Param<int64_t> photographs{"photographs", 9, between(2, 200), "taken from three heights"};
  Param<double> distance{"distance", 5.0, "m", between(0.5, 100), "of the cameras from the facade"};
  Param<int64_t> width{"width", 1800, between(200, 20000), "of a photograph [px]"};
  Param<int64_t> height{"height", 1200, between(200, 20000), "of a photograph [px]"};
  Param<double> noise{"noise", 1.5, "1", between(0, 50), "of grey values"};
  Param<double> rotation_sigma{"rotation_sigma", 2e-5, "rad", between(0, 0.01), "error of each orientation's rotation"};
  Param<double> centre_sigma{"centre_sigma", 5e-5, "m", between(0, 0.1), "error of each projection centre, each axis"};
  Param<double> common_sigma{"common_sigma", 2e-4, "m", between(0, 0.1),
                             "error of all projection centres alike, each axis"};
  OutList<Image> images{"images", "the photographs"};
  Out<Folder> folder{"folder", "where they lie"};
  Out<Design> design{"design", frame("frame=survey"), "the panels as they were designed"};
  Out<Camera> camera{"camera", "that took them, exact"};
  Out<Poses> poses{"poses", frame("frame=survey"), "the orientations with their errors and joint covariance"};
  Out<File> truth{"truth", "panels and joints as they are, CSV: what no processing may see"};
  Out<Surfaces> planted{"planted", frame("frame=survey"), "the same as panels and joints, without errors"};

  void run(Context& context) override {
    const int64_t count = *columns * *rows * *facades;
    if (*plain + *glass > count)
      throw std::runtime_error("there are " + std::to_string(count) + " panels, and " +
                               std::to_string(*plain + *glass) + " of them are to be plain or glass");
    std::vector<PanelledFacade> block;
    for (int64_t f = 0; f < *facades; ++f) block.push_back(build(f, context.seed()));
    const BrownCamera lens = make_camera();
    std::vector<RigidTransform> stations;
    for (int64_t f = 0; f < *facades; ++f)
      for (const RigidTransform& station : place_cameras(f)) stations.push_back(station);
    take_photographs(context, block, lens, stations);
    design.commit(describe_design(block));
    CameraT artifact;
    artifact.id = "simulated", artifact.width = lens.width, artifact.height = lens.height,
    artifact.source = "simulation";
    for (double value : lens.parameters()) artifact.parameters.push_back(value);
    camera.commit(artifact);
    poses.commit(with_errors(stations, context.seed()));
    truth.commit(truth_of(block));
    SurfacesT all;
    for (const PanelledFacade& facade : block) simulate::add_planted_surfaces(facade, *columns, *joint, all);
    planted.commit(all);
  }

 private:
  double across() const {
    return static_cast<double>(*columns) * *panel_width + static_cast<double>(*columns - 1) * *joint;
  }
  double up() const { return static_cast<double>(*rows) * *panel_height + static_cast<double>(*rows - 1) * *joint; }

  /// Facades of a block are so far from its middle that the cameras of one stand behind the plane of the next: no
  /// photograph shows two.
  RigidTransform world_from_facade(int64_t facade) const {
    const double turned = *azimuth - 0.5 * M_PI * static_cast<double>(facade);  // to the right as one looks at it
    const auto out_at = [](double angle) { return Eigen::Vector3d(std::sin(angle), std::cos(angle), 0); };
    const Eigen::Vector3d out = out_at(turned), z = Eigen::Vector3d::UnitZ();
    const double from_middle = std::max(0.5 * across(), 0.6 * *distance) + 0.2;
    Eigen::Matrix3d axes;
    axes << z.cross(out), z, out;
    RigidTransform result;
    result.rotation = Eigen::Quaterniond(axes);
    result.translation = {105.25, 212.5, 31.75};
    if (facade > 0) result.translation += from_middle * (out - out_at(*azimuth));
    return result;
  }

  PanelledFacade build(int64_t number, std::uint64_t seed) const {
    PanelledFacade facade;
    facade.world_from_facade = world_from_facade(number);
    facade.finest = std::max(0.002, 2 * *distance / focal());
    const int64_t count = *columns * *rows, all = *facades * count;
    for (int64_t i = 0; i < count; ++i) {
      const int64_t of_all = number * count + i;
      Random random(seed, "panel", static_cast<std::uint64_t>(of_all));
      RaisedPanel panel;
      const double c = static_cast<double>(i % *columns), r = static_cast<double>(i / *columns);
      const std::string name = fmt::format("P{:02}-{:02}", static_cast<int>(r) + 1, static_cast<int>(c) + 1);
      panel.id = *facades > 1 ? fmt::format("F{}-{}", number + 1, name) : name;
      panel.width = *panel_width, panel.height = *panel_height;
      panel.u = c * (*panel_width + *joint) + 0.5 * *panel_width - 0.5 * across() + random.normal(*place_sigma);
      panel.v = r * (*panel_height + *joint) + 0.5 * *panel_height - 0.5 * up() + random.normal(*place_sigma);
      panel.offset = random.normal(*offset_sigma);
      panel.tilt_u = random.normal(*tilt_sigma), panel.tilt_v = random.normal(*tilt_sigma);
      panel.bow_u = random.normal(*bow_sigma), panel.bow_v = random.normal(*bow_sigma);
      panel.grain = random.bits();
      panel.skin = of_all >= all - *plain ? Skin::plain : of_all >= all - *plain - *glass ? Skin::glass : Skin::plaster;
      facade.panels.push_back(panel);
    }
    return facade;
  }

  /// The facade fills the photograph's width.
  double focal() const {
    return 0.8 * static_cast<double>(*width) * *distance /
           std::max(across(), up() * static_cast<double>(*width) / static_cast<double>(*height));
  }

  BrownCamera make_camera() const {
    BrownCamera lens;
    lens.width = static_cast<int>(*width), lens.height = static_cast<int>(*height);
    lens.fx = lens.fy = focal();
    lens.cx = 0.5 * lens.width + 3.3, lens.cy = 0.5 * lens.height - 2.2;
    lens.k1 = -0.08, lens.k2 = 0.06, lens.p1 = 1e-4, lens.p2 = -1e-4;
    return lens;
  }

  std::vector<RigidTransform> place_cameras(int64_t facade) const {
    std::vector<RigidTransform> stations;
    const RigidTransform frame = world_from_facade(facade);
    const int64_t layers = 3, each = (*photographs + layers - 1) / layers;
    for (int64_t k = 0; k < *photographs; ++k) {
      const double x = each > 1 ? 2.0 * static_cast<double>(k / layers) / static_cast<double>(each - 1) - 1 : 0;
      const double y = static_cast<double>(k % layers) - 1;
      const Eigen::Vector3d centre =
          frame * Eigen::Vector3d(0.45 * *distance * x, 0.3 * *distance * y, *distance * (1 + 0.03 * y * x));
      const Eigen::Vector3d target = frame * Eigen::Vector3d(0.05 * across() * x, 0.05 * up() * y, 0);
      const Eigen::Vector3d forward = (target - centre).normalized();
      const Eigen::Vector3d right = forward.cross(Eigen::Vector3d::UnitZ()).normalized();
      Eigen::Matrix3d world_from_cam;
      world_from_cam << right, forward.cross(right), forward;
      RigidTransform pose;
      pose.rotation = Eigen::Quaterniond(world_from_cam.transpose());
      pose.translation = -(pose.rotation * centre);
      stations.push_back(pose);
    }
    return stations;
  }

  static std::string name_of(size_t k) { return fmt::format("IMG_{:04}.png", k + 1); }

  /// `stations`: of each facade as many, one facade after the other.
  void take_photographs(Context& context, const std::vector<PanelledFacade>& block, const BrownCamera& lens,
                        const std::vector<RigidTransform>& stations) const {
    const auto place = folder.make_folder();
    FolderT listing;
    listing.uri = place.uri;
    context.reserve_memory(static_cast<std::uint64_t>(lens.width) * static_cast<std::uint64_t>(lens.height) * 2);
    for (size_t k = 0; k < stations.size(); ++k) {
      context.progress(static_cast<double>(k) / static_cast<double>(stations.size()), "rendering");
      if (context.cancelled()) throw Stopped();
      const std::string path = place.path + "/" + name_of(k);
      const PanelledFacade& facade = block[k * block.size() / stations.size()];
      simulate::write_png(
          path, lens.width, lens.height,
          simulate::photograph(facade, lens, stations[k], {*noise, 2, derive_seed(context.seed(), "image", k)}));
      ImageT image;
      image.path = name_of(k), image.sha256 = context.digest(path),
      image.uri = "sha256:" + image.sha256 + "/" + image.path;
      image.size = std::filesystem::file_size(path), image.width = lens.width, image.height = lens.height;
      image.camera = "simulated";
      auto file = std::make_unique<FolderEntryT>();
      file->path = image.path, file->sha256 = image.sha256, file->size = image.size;
      listing.files.push_back(std::move(file));
      images.commit(image);
    }
    folder.commit(listing);
  }

  DesignT describe_design(const std::vector<PanelledFacade>& block) const {
    DesignT result;
    result.file_name = "simulated facade", result.schema = "IFC4", result.length_unit = 1;
    result.facade_normal = block.front().world_from_facade.rotation * Eigen::Vector3d::UnitZ();
    result.site_origin = Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
    for (size_t f = 0; f < block.size(); ++f)
      for (size_t i = 0; i < block[f].panels.size(); ++i)
        result.elements.push_back(designed(block[f], i,
                                           block.size() > 1 ? fmt::format("facade {}", f + 1) : std::string("facade"),
                                           "simulated-panel-" + std::to_string(result.elements.size())));
    return result;
  }

  std::unique_ptr<DesignElementT> designed(const PanelledFacade& facade, size_t i, const std::string& of,
                                           const std::string& guid) const {
    const auto c = static_cast<double>(static_cast<int64_t>(i) % *columns),
               r = static_cast<double>(static_cast<int64_t>(i) / *columns);
    auto element = std::make_unique<DesignElementT>();
    element->guid = guid, element->name = facade.panels[i].id;
    element->class_ = "IfcPlate", element->is_panel = true;
    element->storey = "facade";
    element->facade = std::make_unique<FacadeFrameT>();
    element->facade->right = facade.world_from_facade.rotation * Eigen::Vector3d::UnitX();
    element->facade->up = facade.world_from_facade.rotation * Eigen::Vector3d::UnitY();
    element->facade->out = facade.world_from_facade.rotation * Eigen::Vector3d::UnitZ();
    element->facade->source = "own_axes", element->facade->confirmed = true, element->facade->facade = of;
    const Eigen::Vector3d middle(c * (*panel_width + *joint) + 0.5 * *panel_width - 0.5 * across(),
                                 r * (*panel_height + *joint) + 0.5 * *panel_height - 0.5 * up(), 0);
    element->placement = {facade.world_from_facade.rotation, facade.world_from_facade * middle};
    element->position = element->placement.translation;
    element->box_low = {-0.5 * *panel_width, -0.5 * *panel_height, -kThickness};
    element->box_high = {0.5 * *panel_width, 0.5 * *panel_height, 0};
    return element;
  }

  PosesT with_errors(const std::vector<RigidTransform>& stations, std::uint64_t seed) const {
    const Eigen::Index n = static_cast<Eigen::Index>(stations.size());
    // Errors of rotation vectors and projection centres; the translation is t = −R C, so dt = −[t]× δ − R dC.
    Eigen::MatrixXd errors = Eigen::MatrixXd::Zero(6 * n, 6 * n), by = Eigen::MatrixXd::Zero(8 * n + 9, 6 * n);
    Random random(seed, "orientations");
    const Eigen::Vector3d moved = random.normal3(*common_sigma);  // of all projection centres
    PosesT result;
    result.cameras = {"simulated"};
    for (Eigen::Index k = 0; k < n; ++k) {
      const RigidTransform& right = stations[k];
      const Eigen::Matrix3d turn = right.rotation.toRotationMatrix();
      for (Eigen::Index l = 0; l < n; ++l)
        errors.block<3, 3>(6 * k + 3, 6 * l + 3).diagonal().array() += *common_sigma * *common_sigma;
      errors.diagonal().segment<3>(6 * k).array() += *rotation_sigma * *rotation_sigma;
      errors.diagonal().segment<3>(6 * k + 3).array() += *centre_sigma * *centre_sigma;
      by.block<3, 3>(8 * k, 6 * k).setIdentity();
      by.block<3, 3>(8 * k + 3, 6 * k) = -skew(right.translation);
      by.block<3, 3>(8 * k + 3, 6 * k + 3) = -turn;
      auto entry = std::make_unique<PoseT>();
      entry->path = name_of(static_cast<size_t>(k));
      const Eigen::Vector3d turned = random.normal3(*rotation_sigma);
      const Eigen::Vector3d centre = right.inverse().translation + moved + random.normal3(*centre_sigma);
      entry->cam_from_world.rotation = quaternion_from_rotation_vector(turned) * right.rotation;
      entry->cam_from_world.translation = -(entry->cam_from_world.rotation * centre);
      result.poses.push_back(std::move(entry));
    }
    const Eigen::MatrixXd covariance = by * errors * by.transpose();
    for (Eigen::Index k = 0; k < n; ++k)
      result.poses[k]->covariance = pack_symmetric(covariance.block<6, 6>(8 * k, 8 * k));
    result.joint_covariance = pack_symmetric(covariance);
    return result;
  }

  FileT truth_of(const std::vector<PanelledFacade>& block) const {
    std::string text =
        "panel,skin,offset_mm,tilt_right_mm_per_m,tilt_up_mm_per_m,bow_across_mm,bow_up_mm,u_m,v_m,width_m,height_m\n";
    for (const PanelledFacade& facade : block)
      for (const RaisedPanel& panel : facade.panels)
        text += fmt::format("{},{},{:.6f},{:.6f},{:.6f},{:.6f},{:.6f},{:.7f},{:.7f},{:.7f},{:.7f}\n", panel.id,
                            simulate::to_string(panel.skin), 1e3 * panel.offset, 1e3 * panel.tilt_u, 1e3 * panel.tilt_v,
                            1e3 * panel.bow_u, 1e3 * panel.bow_v, panel.u, panel.v, panel.width, panel.height);
    FileT file;
    file.name = "truth.csv", file.media_type = "text/csv", file.content.assign(text.begin(), text.end());
    return file;
  }
};

}  // namespace

PLUMBLINE_PLUGIN("simulate_facade", PLUMBLINE_BUILD_ID, "MIT", SimulateFacade, plumbline::simulate::SimulateScan)
