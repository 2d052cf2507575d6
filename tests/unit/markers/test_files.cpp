// Files around photographs: dictionaries, cameras, layouts, control, COLMAP models.
#include <gmock/gmock.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <random>
#include <set>
#include <sstream>

#include "photo/cameras/camera_files.hpp"
#include "photo/cameras/camera_groups.hpp"
#include "photo/cameras/colmap_files.hpp"
#include "photo/detect/tag_dictionary.hpp"
#include "photo/markers/layout_files.hpp"
#include "photo/markers/robust_similarity.hpp"
#include "photo/markers/survey_frame.hpp"
#include "test_support.hpp"

namespace plumbline {
namespace test_files {

using testing::HasSubstr;

template <typename Work>
std::string message_of(Work&& work) {
  try {
    work();
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "nothing was thrown";
}

TEST(TagDictionary, ReadsWhatOpenCVWritesAndChecksIt) {
  const auto d = detect::parse_dictionary(
      "%YAML:1.0\n---\nnmarkers: 2\nmarkersize: 3\nmaxCorrectionBits: 4\nmarker_0: \"110001010\"\nmarker_5: "
      "\"100111101\"\n",
      "mine.yml");
  EXPECT_EQ(d.size, 3);
  EXPECT_EQ(d.ids, (std::vector<int>{0, 5}));
  EXPECT_LE(d.correctable_bits, 1) << "never more than half the distance of the codes";
  EXPECT_THAT(
      message_of([] { detect::parse_dictionary("nmarkers: 1\nmarkersize: 3\nmarker_0: \"11000\"\n", "a.yml"); }),
      HasSubstr("a.yml: marker_0 has 5 cells, expected 9"));
  EXPECT_THAT(
      message_of([] { detect::parse_dictionary("nmarkers: 3\nmarkersize: 3\nmarker_0: \"110001010\"\n", "a.yml"); }),
      HasSubstr("nmarkers is 3, but there are 1"));
  EXPECT_THAT(message_of([] {
                detect::parse_dictionary("markersize: 3\nmarker_0: \"110001010\"\nmarker_1: \"001101010\"\n", "a.yml");
              }),
              HasSubstr("same"));
  EXPECT_THAT(message_of([] { detect::builtin_dictionary("DICT_9X9_50"); }), HasSubstr("DICT_6X6_1000"));
  EXPECT_EQ(detect::builtin_dictionary("apriltag_36h11").name, "tag36h11");
  EXPECT_EQ(detect::builtin_dictionary("5x5_100").name, "DICT_5X5_100");
}

TEST(TagDictionary, IsReadInEveryFormItIsFoundIn) {
  const std::vector<std::string> forms = {
      "<?xml version=\"1.0\"?>\n<opencv_storage>\n<nmarkers>2</nmarkers>\n<markersize>3</markersize>\n"
      "<marker_0>\"110001010\"</marker_0>\n<marker_1>100111101</marker_1>\n</opencv_storage>\n",
      "{\"nmarkers\": 2, \"markersize\": 3, \"marker_0\": \"110001010\", \"marker_1\": \"100111101\"}",
      "%YAML:1.0\n---\nmine:\n   nmarkers: 2\n   markersize: 3\n   marker_0: \"110001010\"\n   marker_1: "
      "\"100111101\"\n",
      "mine\n9\n1 1 0 0 0 1 0 1 0\n100111101\n", "[[[1, 1, 0], [0, 0, 1], [0, 1, 0]], [\"100\", \"111\", \"101\"]]",
      "markersize: 3\nmarker_0: [[1, 1, 0], [0, 0, 1], [0, 1, 0]]\nmarker_1: [100, 111, 101]\n",
      // Four turns of each code, the ninth cell in a byte of its own.
      "static unsigned char MINE_BYTES[][4][2] = { // of 3 x 3\n  { {197, 0}, {86, 0}, {81, 1}, {53, 0} },\n"
      "  { {158, 1}, {107, 1}, {188, 1}, {235, 0} },\n};\n",
      // Bits of libapriltag go round the square.
      "static uint64_t codedata[2] = {\n 0x00000000000001a8UL,\n 0x0000000000000137UL,\n};\ntf->ncodes = 2;\n"
      "tf->name = strdup(\"mine\");\ntf->bit_x[0] = 1;\ntf->bit_y[0] = 1;\ntf->bit_x[1] = 2;\ntf->bit_y[1] = 1;\n"
      "tf->bit_x[2] = 3;\ntf->bit_y[2] = 1;\ntf->bit_x[3] = 3;\ntf->bit_y[3] = 2;\ntf->bit_x[4] = 3;\n"
      "tf->bit_y[4] = 3;\ntf->bit_x[5] = 2;\ntf->bit_y[5] = 3;\ntf->bit_x[6] = 1;\ntf->bit_y[6] = 3;\n"
      "tf->bit_x[7] = 1;\ntf->bit_y[7] = 2;\ntf->bit_x[8] = 2;\ntf->bit_y[8] = 2;\ntf->width_at_border = 5;\n"
      "tf->reversed_border = false;\n",
      "const unsigned long long mine[] = { 0x018aULL, 0x013dULL };\nconst TagCodes codes = TagCodes(9, 1, mine, 2);\n"};
  for (const auto& text : forms) {
    const auto d = detect::parse_dictionary(text, "mine.txt");
    EXPECT_EQ(d.size, 3) << text;
    ASSERT_EQ(d.codes.size(), 2u) << text;
    EXPECT_EQ(d.codes[0], (std::vector<std::uint8_t>{1, 1, 0, 0, 0, 1, 0, 1, 0})) << text;
    EXPECT_EQ(d.codes[1], (std::vector<std::uint8_t>{1, 0, 0, 1, 1, 1, 1, 0, 1})) << text;
  }
}

TEST(TagDictionary, IdsThatStandBesideTheCodesAreTheirs) {
  for (const std::string text :
       {"id,bits\n7,110001010\n10,100111101\n", "# mine\n7: 110001010\n10: 100111101\n",
        "7 \"110001010\"\n10 \"100111101\"\n", "{\"7\": [[1, 1, 0], [0, 0, 1], [0, 1, 0]], \"10\": \"100111101\"}",
        "{\"markers\": [{\"id\": 7, \"bits\": \"110001010\"}, {\"id\": 10, \"code\": [100, 111, 101]}]}"}) {
    const auto d = detect::parse_dictionary(text, "mine.txt");
    EXPECT_EQ(d.ids, (std::vector<int>{7, 10})) << text;
    ASSERT_EQ(d.codes.size(), 2u) << text;
    EXPECT_EQ(d.codes[1], (std::vector<std::uint8_t>{1, 0, 0, 1, 1, 1, 1, 0, 1})) << text;
  }
  for (const auto& [text, words] :
       {std::pair("110001010\n7 100111101\n", "line 2 holds more than the cells of one marker"),
        std::pair("7,110001010\n7,100111101\n", "the id 7 occurs twice"),
        std::pair("codes = ['110001010', '100111101']\n", "line 1 holds more"),
        std::pair("{\"markers\": [{\"bits\": \"110001010\"}]}", "entry 1 of the list of markers has no id")})
    EXPECT_THAT(message_of([&] { detect::parse_dictionary(text, "mine"); }), HasSubstr(words)) << text;
}

TEST(TagDictionary, TheDefaultOfTheArucoLibraryIsBuiltIn) {
  const auto d = detect::builtin_dictionary("DICT_ARUCO_MIP_36h12");
  EXPECT_EQ(d.name, "ARUCO_MIP_36h12");
  EXPECT_EQ(d.codes.size(), 250u);
  EXPECT_EQ(detect::smallest_distance(d), 12);
}

TEST(TagDictionary, RefusesInWordsWhatItIsNot) {
  const auto words = [](const std::string& text) {
    return message_of([&] { detect::parse_dictionary(text, "mine"); });
  };
  EXPECT_THAT(words(std::string("\x93NUMPY\1\0", 8)), HasSubstr("binary file"));
  EXPECT_THAT(words("tf->bit_x[0] = -2;\ntf->bit_y[0] = -2;\ntf->width_at_border = 5;\nreversed_border = true;\n"
                    "codes[0] = 0x0001UL;"),
              HasSubstr("do not fill a square inside one black border"));
  EXPECT_THAT(words("unsigned char A[][4][2] = {{{1,2},{3,4},{5,6},{7,8}}};"), HasSubstr("not its four turns"));
  EXPECT_THAT(words("unsigned char A[][4][2] = {{{1,2}}};"), HasSubstr("no multiple of 4 x 2"));
  EXPECT_THAT(words("a: {marker_0: \"110001010\"}\nb: {marker_0: \"110001010\"}"), HasSubstr("several dictionaries"));
  EXPECT_THAT(words("static uint64_t codedata[1] = { 0x0000ffffUL };"), HasSubstr("size of the tags"));
}

/// Each holds the first code of DICT_4X4_50.
TEST(Dictionaries, AsTablesThatPeopleWrite) {
  const auto code = detect::builtin_dictionary("DICT_4X4_50").codes[0];
  for (const char* text :
       {"%YAML:1.0\n---\nmarkerSize: 4\nmaxCorrectionBits: 1\nbytesList: !!opencv-matrix\n   rows: 1\n   cols: 2\n"
        "   dt: \"4u\"\n   data: [ 181, 50, 235, 72, 76, 173, 18, 215 ]\n",
        "{\"bytesList\": {\"type_id\": \"opencv-matrix\", \"rows\": 1, \"cols\": 2, \"dt\": \"4u\", \"data\": "
        "[181, 50, 235, 72, 76, 173, 18, 215]}}",
        // What a script wrote under a name of its own, without the size.
        "%YAML:1.0\n---\ncustom_dictionary: !!opencv-matrix\n   rows: 1\n   cols: 2\n   dt: \"4u\"\n"
        "   data: [ 181, 50, 235, 72, 76, 173, 18, 215 ]\n",
        "AR.DICTIONARIES['MINE'] = {nBits: 16, tau: 4, codeList: ['0xb532']};\n",
        "{\"markerSize\": 4, \"markers\": [[[1,0,1,1],[0,1,0,1],[0,0,1,1],[0,0,1,0]]]}",
        "{\"codes\": [\"1011010100110010\"]}"}) {
    const auto read = detect::parse_dictionary(text, "mine");
    ASSERT_EQ(read.codes.size(), 1u) << text;
    EXPECT_EQ(read.size, 4) << text;
    EXPECT_EQ(read.codes[0], code) << text;
  }
  for (const auto& [text, words] :
       {std::pair("bytesList: {rows: 1, cols: 2, data: [181, 50, 235]}\n", "bytesList has 1 rows and 3 values"),
        std::pair("markerSize: 5\nbytesList: {rows: 1, data: [181, 50, 235, 72, 76, 173, 18, 215]}\n",
                  "no marker of 5 x 5 cells"),
        std::pair("a: {rows: 1, data: [1]}\nb: {rows: 1, data: [1]}\n", "holds several matrices (a, b)"),
        std::pair("nBits: 16\ncodeList: ['0xb532f']\n", "'0xb532f' in codeList is no number of 16 bits"),
        std::pair("codeList: ['0xb532']\n", "nBits is missing")})
    EXPECT_THAT(message_of([&] { detect::parse_dictionary(text, "mine"); }), HasSubstr(words));
}

TEST(TagDictionary, SaysHowWeakItIs) {
  EXPECT_THAT(detect::weakness_of(detect::builtin_dictionary("DICT_3X3_32")),
              testing::AllOf(HasSubstr("32 codes of 3 x 3 cells"), HasSubstr("25 %"), HasSubstr("in any turn is 1")));
  EXPECT_EQ(detect::weakness_of(detect::builtin_dictionary("DICT_6X6_250")), "");
  auto bordered = detect::builtin_dictionary("DICT_5X5_50");
  for (auto& code : bordered.codes)
    for (int k = 0; k < 5; ++k)
      for (const int at : {k, 20 + k, 5 * k, 5 * k + 4}) code[at] = 0;
  EXPECT_THAT(detect::weakness_of(bordered), HasSubstr("leave them out of the file"));
}

TEST(CameraFiles, AValueThatIsNoneIsRefusedWithItsLine) {
  const std::string kalibr = "cam0:\n  camera: [460.6, 459.3, 373.0, 256.1]\n  distortion_model: radtan\n";
  for (const auto& [text, words] :
       {std::pair(kalibr + "  distortion_coeffs: [-0.28, 0.08, 0.0, -0.0001]\n  resolution: [752, PNG480]\n",
                  "line 5 has '[752, PNG480]', expected width and height in pixels"),
        std::pair(kalibr + "  distortion_coeffs: [-0.28, O.08, 0.0, -0.0001]\n  resolution: [752, 480]\n",
                  "line 4 has '[-0.28, O.08, 0.0, -0.0001]', expected the coefficients of distortion"),
        std::pair(std::string("image_width: 640px\nimage_height: 480\nfx: 800\ncx: 320\ncy: 240\n"),
                  "line 1 has '640px', expected a number of pixels"),
        std::pair(std::string("image_width: 640\nimage_height: 480\nfx: 800\ncx: 320\ncy: 240\nk1: -0,1\n"),
                  "line 6 has '-0,1', expected a number: k1"),
        std::pair(std::string("plumbline_camera: 1\nparameters: {fx: [], fy: 800, cx: 320, cy: 240}\n"),
                  "line 2 has '[]', expected a number: fx")})
    EXPECT_THAT([&] { cameras::parse_camera_files(text, "camchain.yaml"); },
                ThrowsMessage<std::runtime_error>(HasSubstr(words)));
}

TEST(CameraFiles, OfOpenCVRosKalibrAndOurs) {
  const auto opencv = cameras::parse_camera_file(
      "%YAML:1.0\n---\nimage_width: 640\nimage_height: 480\ncamera_matrix: !!opencv-matrix\n   rows: 3\n   cols: 3\n   "
      "dt: d\n   data: [ 600., 0., 320., 0., 610., 240., 0., 0., 1. ]\n"
      "distortion_coefficients: !!opencv-matrix\n   rows: 5\n   cols: 1\n   dt: d\n   data: [ 0.1, 0.2, 0.003, 0.004, "
      "0.5 ]\n",
      "o.yml");
  EXPECT_EQ(opencv.camera.width, 640);
  EXPECT_EQ(opencv.camera.fy, 610);
  EXPECT_EQ(opencv.camera.p2, 0.004);
  EXPECT_EQ(opencv.camera.k3, 0.5);
  const auto xml = cameras::parse_camera_file(
      "<?xml version=\"1.0\"?><opencv_storage><Camera_Matrix "
      "type_id=\"opencv-matrix\"><rows>3</rows><cols>3</cols><dt>d</dt><data>500 0 300 0 500 200 0 0 "
      "1</data></Camera_Matrix>"
      "<Distortion_Coefficients><rows>1</rows><cols>4</cols><data>-0.1 0.02 0 "
      "0</data></Distortion_Coefficients></opencv_storage>",
      "o.xml");
  EXPECT_EQ(xml.camera.cx, 300);
  EXPECT_EQ(xml.camera.k1, -0.1);
  EXPECT_EQ(xml.camera.width, 0);
  const auto kalibr = cameras::parse_camera_file(
      "cam0:\n  camera_model: pinhole\n  intrinsics: [461.6, 460.3, 362.7, 248.1]\n  distortion_model: radtan\n  "
      "distortion_coeffs: [-0.28, 0.07, 0.0002, 1.7e-05]\n  resolution: [752, 480]\n",
      "chain.yaml");
  EXPECT_EQ(kalibr.camera.fx, 461.6);
  EXPECT_EQ(kalibr.camera.height, 480);
  const auto ours = cameras::parse_camera_file(
      cameras::camera_yaml({"x", opencv.camera, Eigen::MatrixXd::Identity(9, 9) * 4, ""}), "camera.yaml");
  EXPECT_EQ(ours.camera.parameters(), opencv.camera.parameters());
  EXPECT_DOUBLE_EQ(ours.covariance(0, 0), 4);
  EXPECT_THAT(message_of([] { cameras::parse_camera_file("camera_matrix: [1, 2, 3]\n", "bad.yml"); }),
              HasSubstr("bad.yml"));
  EXPECT_THAT(message_of([] {
                cameras::parse_camera_file(
                    "intrinsics: [500, 500, 300, 200]\ndistortion_model: ds\nresolution: [640, 480]\n", "f.yaml");
              }),
              HasSubstr("'ds'; known are Brown's (plumb_bob, radtan) and the fisheye"));
}

/// A lens model is told by its whole name: parts of it are in the names of cameras.
TEST(CameraFiles, TellTheLensByWholeNames) {
  const auto read = [](const std::string& line) {
    return cameras::parse_camera_file("intrinsics: [500, 500, 300, 200]\n" + line +
                                          "\ndistortion_coeffs: [0.1, 0.01, 0, 0]\nresolution: [640, 480]\n",
                                      "c.yaml")
        .camera.lens;
  };
  for (const char* line :
       {"model: DS-2CD2042", "camera_model: Foveon", "model: Equinox 3", "distortion_model: plumb_bob"})
    EXPECT_EQ(read(line), LensModel::brown) << line;
  for (const char* line : {"camera_model: KannalaBrandt8", "distortion_model: equidistant", "model: OPENCV_FISHEYE"})
    EXPECT_EQ(read(line), LensModel::fisheye) << line;
  for (const char* line : {"distortion_model: division", "camera_model: omni\ndistortion_model: radtan", "model: FOV",
                           "model: SIMPLE_RADIAL_FISHEYE", "camera_model: Kannala-Brandt-6"})
    EXPECT_THAT(message_of([&] { read(line); }), HasSubstr("known are Brown's")) << line;
}

/// What RealSense states of a camera, in Brown's letters and another formula: with Brown's a corner of the image would
/// lie pixels off, and nothing would say so.
TEST(CameraFiles, OfInverseAndModifiedModelsAreBrownsOnlyWithoutDistortion) {
  const auto read = [](const std::string& model, const std::string& coefficients) {
    return cameras::parse_camera_file("width: 640\nheight: 480\nfx: 600\nfy: 600\nppx: 320\ncx: 320\ncy: 240\nmodel: " +
                                          model + "\ncoeffs: " + coefficients + "\ndistortion: " + coefficients + "\n",
                                      "realsense.yaml")
        .camera;
  };
  for (const char* model : {"Inverse Brown Conrady", "RS2_DISTORTION_INVERSE_BROWN_CONRADY",
                            "distortion.inverse_brown_conrady", "Modified Brown Conrady", "inverse radial"}) {
    EXPECT_EQ(read(model, "[0, 0, 0, 0, 0]").k1, 0) << model;
    for (const char* coefficients : {"[0.1, 0, 0, 0, 0]", "[0, 0, 0, 0, 0.2]", "[0, 0, 0, 1e-4, 0]"})
      EXPECT_THAT(message_of([&] { read(model, coefficients); }),
                  testing::AllOf(HasSubstr("realsense.yaml"), HasSubstr(model), HasSubstr("not those of Brown's")))
          << coefficients;
  }
  EXPECT_EQ(read("Brown Conrady", "[0.1, 0, 0, 0, 0]").k1, 0.1);
}

TEST(CameraFiles, OfFisheyes) {
  // TUM VI's 512 x 512 camera, as Kalibr writes it.
  const std::string kalibr =
      "cam0:\n  camera_model: pinhole\n  intrinsics: [190.97847715128717, 190.9733070521226, 254.93170605935475, "
      "256.8974428996504]\n  distortion_model: equidistant\n  distortion_coeffs: [0.0034823894022493434, "
      "0.0007150348452162257, -0.0020532361418706202, 0.00020293673591811182]\n  resolution: [512, 512]\n";
  const auto read = cameras::parse_camera_file(kalibr, "camchain.yaml");
  EXPECT_EQ(read.camera.lens, LensModel::fisheye);
  EXPECT_EQ(read.camera.k1, 0.0034823894022493434);
  EXPECT_EQ(read.camera.k4, 0.00020293673591811182);
  EXPECT_EQ(read.camera.p1, 0);
  const auto opencv = cameras::parse_camera_file(
      "<?xml version=\"1.0\"?><opencv_storage><fisheye_model>1</fisheye_model><camera_matrix "
      "type_id=\"opencv-matrix\"><data>318 0 499.5 0 319 374.5 0 0 1</data></camera_matrix>"
      "<distortion_coefficients><data>0.1 0.2 0.3 0.4</data></distortion_coefficients></opencv_storage>",
      "o.xml");
  EXPECT_EQ(opencv.camera.parameters(), (std::array<double, 9>{318, 319, 499.5, 374.5, 0.1, 0.2, 0.3, 0.4, 0}));
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(9, 9);
  covariance.diagonal().head<8>().setConstant(4);
  covariance(7, 2) = covariance(2, 7) = 1;
  const std::string text = cameras::camera_yaml({"x", read.camera, covariance, ""});
  EXPECT_THAT(text, HasSubstr("lens: fisheye"));
  EXPECT_THAT(text, testing::Not(HasSubstr("p1")));
  const auto ours = cameras::parse_camera_file(text, "camera.yaml");
  EXPECT_EQ(ours.camera.lens, LensModel::fisheye);
  EXPECT_EQ(ours.camera.parameters(), read.camera.parameters());
  EXPECT_LT((ours.covariance - covariance).norm(), 1e-12);
  const auto changed = [&](const std::string& from, const std::string& to) {
    std::string wrong = text;
    wrong.replace(wrong.find(from), from.size(), to);
    return message_of([&] { cameras::parse_camera_file(wrong, "camera.yaml"); });
  };
  EXPECT_THAT(changed("lens: fisheye", "lens: fish"), HasSubstr("'fish', expected the lens: brown or fisheye"));
  EXPECT_THAT(changed("  k4:", "  p1:"), HasSubstr("'parameters' has no 'p1', only fx, fy, cx, cy, k1, k2, k3, k4"));
  std::string five = kalibr;
  five.replace(five.find("0.00020293673591811182]"), 1, "1, 0");
  EXPECT_THAT(message_of([&] { cameras::parse_camera_file(five, "camchain.yaml"); }),
              HasSubstr("has 5 coefficients of distortion, a fisheye (equidistant, Kannala-Brandt) has 4"));
}

/// Correlations of 0.99 are the difference between a ray at the corner known to 2.6 px and to 6.5.
TEST(CameraFiles, CarryTheWholeCovariance) {
  std::mt19937_64 random(3);
  std::normal_distribution<double> noise(0, 1);
  const std::array<double, 9> sigmas = {2, 2.1, 3, 2.5, 0.005, 0.06, 0, 1e-4, 2e-4};  // k3 was held
  Eigen::MatrixXd spread(9, 12);
  for (Eigen::Index i = 0; i < 9; ++i)
    for (Eigen::Index j = 0; j < 12; ++j) spread(i, j) = noise(random);
  spread.row(1) = spread.row(0) + 0.1 * spread.row(1), spread.row(5) = -spread.row(4) + 0.2 * spread.row(5);
  Eigen::MatrixXd covariance = spread * spread.transpose();
  const Eigen::VectorXd scale =
      Eigen::Map<const Eigen::VectorXd>(sigmas.data(), 9).cwiseQuotient(covariance.diagonal().cwiseSqrt());
  covariance = scale.asDiagonal() * covariance * scale.asDiagonal();
  BrownCamera camera;
  camera.width = 1280, camera.height = 720, camera.fx = 1124, camera.fy = 1125, camera.cx = 640, camera.cy = 360;
  camera.k1 = 0.13;
  const std::string text = cameras::camera_yaml({"x", camera, covariance, "", {"sigmas: 2.1 times\nas large"}});
  const auto read = cameras::parse_camera_file(text, "camera.yaml");
  EXPECT_LT((read.covariance - covariance).cwiseAbs().maxCoeff(), 1e-12);
  for (Eigen::Index i = 0; i < 9; ++i)
    for (Eigen::Index j = 0; j < 9; ++j)
      EXPECT_NEAR(read.covariance(i, j), covariance(i, j), 1e-12 * sigmas[i] * sigmas[j]);
  EXPECT_THAT(text, testing::StartsWith("# sigmas: 2.1 times as large\nplumbline_camera: 1"));
  // Under a name, as of several cameras.
  std::string indented = "left:\n";
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) indented += "  " + line + "\n";
  EXPECT_LT((cameras::parse_camera_file(indented, "c.yaml", "left").covariance - covariance).norm(), 1e-12);
}

TEST(CameraFiles, CorrelationsThatAreNoneAreRefused) {
  const auto refused = [](const std::string& correlations) {
    return message_of([&] {
      cameras::parse_camera_file(
          "plumbline_camera: 1\nwidth: 4000\nheight: 3000\nparameters: {fx: 3000, fy: 3000, cx: 2000, cy: 1500}\n"
          "sigmas: {fx: 1, fy: 1, cx: 2, cy: 2}\ncorrelations: " +
              correlations + "\n",
          "c.yaml");
    });
  };
  EXPECT_EQ(refused("{fy: [0.99], cy: [0, 0.1, -0.5]}"), "nothing was thrown");
  EXPECT_THAT(refused("{fy: [1.2]}"), HasSubstr("the correlation of fy with fx is not between -1 and 1"));
  EXPECT_THAT(refused("{cx: [0.5]}"), HasSubstr("the correlations of cx are 1 numbers, expected 2"));
  EXPECT_THAT(refused("{fy: [0.9], cx: [0.9, -0.9]}"), HasSubstr("of no covariance"));
  EXPECT_THAT(refused("{fY: [0.9]}"), HasSubstr("'correlations' has no 'fY'"));
  EXPECT_THAT(refused("{fy: [abc]}"), HasSubstr("expected numbers from -1 to 1"));
  EXPECT_THAT(refused("[0.9]"), HasSubstr("expected a map of parameters"));
}

TEST(CameraFiles, MistypedNamesAndImpossibleNumbersAreRefused) {
  const auto refused = [](const std::string& parameters, const std::string& more) {
    return message_of([&] {
      cameras::parse_camera_file(
          "plumbline_camera: 1\nwidth: 4000\nheight: 3000\nparameters: {" + parameters + "}\n" + more, "c.yaml");
    });
  };
  const std::string sound = "fx: 3000, fy: 3000, cx: 2000, cy: 1500";
  EXPECT_EQ(refused(sound + ", k1: -0.1", "sigmas: {fx: 1, k1: 0}\n"), "nothing was thrown");
  EXPECT_THAT(refused(sound + ", k_1: -0.1", ""),
              HasSubstr("line 4: 'parameters' has no 'k_1', only fx, fy, cx, cy, k1"));
  EXPECT_THAT(refused(sound, "sigmas: {FX: 1}\n"), HasSubstr("line 5: 'sigmas' has no 'FX'"));
  EXPECT_THAT(refused(sound, "sigmas: {cx: -1}\n"),
              HasSubstr("'-1', expected a standard deviation of cx of 0 or more"));
  EXPECT_THAT(refused(sound, "sigmas: [1, 1]\n"), HasSubstr("expected a map of parameters"));
  EXPECT_THAT(refused("fx: 3000, fy: 3000, cx: 2000", ""), HasSubstr("'parameters' has no cy"));
  const std::string matrix = "camera_matrix: [3000, 0, 2000, 0, 3000, 1500, 0, 0, 1]\n";
  for (const std::string list : {"[-0.1]", "[-0.1, 0.05]", "[-0.1, 0.05, 0.01]"})
    EXPECT_THAT(message_of([&] { cameras::parse_camera_file(matrix + "dist_coeffs: " + list + "\n", "o.yaml"); }),
                HasSubstr("coefficients of distortion, expected are 4 (k1, k2, p1, p2), 5 (and k3)"));
  EXPECT_EQ(message_of([&] { cameras::parse_camera_file(matrix + "dist_coeffs: [-0.1, 0.05, 0, 0]\n", "o.yaml"); }),
            "nothing was thrown");
}

TEST(CameraFiles, OfSeveralCamerasAreReadByName) {
  const std::string one =
      "  plumbline_camera: 1\n  width: 640\n  height: 480\n  parameters: {fx: 500, fy: 501, cx: 320, cy: 240}\n";
  const std::string text = "\"left\":\n" + one + "\"rig/right\":\n" + one;
  const auto cameras = cameras::parse_camera_files(text, "c.yaml");
  ASSERT_EQ(cameras.size(), 2u);
  EXPECT_EQ(cameras[1].id, "rig/right");
  EXPECT_EQ(cameras[1].camera.width, 640);
  EXPECT_EQ(cameras::parse_camera_files(text, "c.yaml", "left").size(), 1u);
  EXPECT_THAT(message_of([&] { cameras::parse_camera_file(text, "c.yaml"); }),
              testing::AllOf(HasSubstr("several cameras; choose one with which="), HasSubstr("'left', 'rig/right'")));
  // Kalibr's camchain of a rig: not silently its first camera.
  const std::string kalibr =
      "  intrinsics: [461.6, 460.3, 362.7, 248.1]\n  distortion_model: radtan\n"
      "  distortion_coeffs: [-0.28, 0.07, 0.0002, 1.7e-05]\n  resolution: [752, 480]\n";
  const std::string chain = "cam0:\n" + kalibr + "cam1:\n" + kalibr;
  const auto rig = cameras::parse_camera_files(chain, "chain.yaml");
  ASSERT_EQ(rig.size(), 2u);
  EXPECT_EQ(rig[1].id, "cam1");
  EXPECT_EQ(rig[1].format, "Kalibr");
  EXPECT_THAT(message_of([&] { cameras::parse_camera_file(chain, "chain.yaml"); }), HasSubstr("'cam0', 'cam1'"));
}

TEST(CameraGroups, AreToldFromFoldersAndNames) {
  EXPECT_EQ(cameras::camera_name("rig/left/0017.png", "by_folder"), "rig/left");
  EXPECT_EQ(cameras::camera_name("rig/left/0017.png", "by_name"), "rig/left");
  EXPECT_EQ(cameras::camera_name("cam_0_frame_0017.png", "by_name"), "cam_0_frame");
  EXPECT_EQ(cameras::camera_name("left01.jpg", "by_name"), "left");
  EXPECT_EQ(cameras::camera_name("left01.jpg", "one"), "");
  // The number first: each moment was a camera of its own.
  EXPECT_EQ(cameras::camera_name("rig/0017_left.png", "by_name"), "rig/left");
  EXPECT_EQ(cameras::camera_name("0017_cam2.png", "by_name"), "cam2");
  EXPECT_EQ(cameras::camera_name("frame0017-Camera 10.png", "by_name"), "frame_Camera 10");
  EXPECT_EQ(cameras::moment_of("frame0017-Camera 10.png", "by_name"), "17");
  EXPECT_EQ(cameras::camera_name("cam10_5.png", "by_name"), "cam10");
  EXPECT_EQ(cameras::moment_of("rig/cam3.png", "by_name"), "3") << "the only number";
  EXPECT_EQ(
      cameras::suspected_cameras({"1_cam0.png", "2_cam0.png", "3_cam0.png", "1_cam1.png", "2_cam1.png", "3_cam1.png"}),
      "cam0 and cam1");
  EXPECT_EQ(cameras::moment_of("a/cam_0_frame_0050.jpg", "by_name"), cameras::moment_of("b/cam1_50.jpg", "by_name"));
  EXPECT_EQ(cameras::moment_of("2024-01-01/first.jpg", "by_name"), "first.jpg");
  EXPECT_EQ(
      cameras::suspected_cameras({"left1.jpg", "left2.jpg", "left3.jpg", "right1.jpg", "right2.jpg", "right3.jpg"}),
      "left and right");
  EXPECT_EQ(cameras::suspected_cameras({"a1.jpg", "a2.jpg", "a3.jpg", "b4.jpg", "b5.jpg", "b6.jpg"}), "")
      << "names that only count on";
}

TEST(CameraGroups, FoldersOfMomentsAreFoundOut) {
  const std::vector<std::string> rig = {"run/0001/cam0.png", "run/0001/cam1.png", "run/0002/cam0.png",
                                        "run/0002/cam1.png", "run/0003/cam1.png", "run/0003/cam0.png"};
  EXPECT_EQ(cameras::cameras_told(rig, "by_folder"), "by_file");
  EXPECT_EQ(cameras::cameras_told(rig, "by_name"), "by_file");
  EXPECT_EQ(cameras::cameras_told(rig, "one"), "one");
  EXPECT_EQ(cameras::camera_name("run/0001/cam1.png", "by_file"), "cam1");
  EXPECT_EQ(cameras::moment_of("run/0003/cam1.png", "by_file"), "run/0003");
  // The folder's number once more in the name; but not any number that is alike.
  EXPECT_EQ(cameras::camera_name("0017/cam1_0017.png", "by_file"), "cam1");
  EXPECT_EQ(cameras::camera_name("0017/0017_left.png", "by_file"), "left");
  EXPECT_EQ(cameras::camera_name("1/img_1.png", "by_file"), "img_1");
  EXPECT_EQ(cameras::camera_name("0017/0017.png", "by_file"), "0017");
  EXPECT_EQ(
      cameras::cameras_told(
          {"t1/left.png", "t1/right.png", "t2/left.png", "t2/right.png", "t3/left.png", "t3/right.png"}, "by_folder"),
      "by_file");
  // A folder for each camera, with the same numbers.
  EXPECT_EQ(
      cameras::cameras_told({"cam0/01.png", "cam0/02.png", "cam1/01.png", "cam1/02.png", "cam2/01.png", "cam2/02.png"},
                            "by_folder"),
      "by_folder");
  EXPECT_EQ(cameras::cameras_told(
                {"1/IMG_01.png", "1/IMG_02.png", "2/IMG_01.png", "2/IMG_02.png", "3/IMG_01.png", "3/IMG_02.png"},
                "by_folder"),
            "by_folder");
  EXPECT_EQ(cameras::cameras_told({"left/cam.png", "right/cam.png", "top/cam.png", "left/a.png"}, "by_folder"),
            "by_folder");
  // Two walls by one camera each are no moments.
  EXPECT_EQ(cameras::cameras_told({"wall1/left.png", "wall1/right.png", "wall2/left.png"}, "by_folder"), "by_folder");
}

TEST(CameraGroups, TimesThatDifferByLittleAreOneMoment) {
  const auto moments = cameras::moments_of(
      {{"cam0/data/1403636579763555584.png", "cam0/data/1403636579813555456.png", "cam0/data/1403636580063555584.png"},
       {"cam1/data/1403636579763561000.png", "cam1/data/1403636579813540000.png", "cam1/data/1403636579863555584.png"}},
      "by_folder");
  EXPECT_EQ(moments[0][0], moments[1][0]) << "5 microseconds later";
  EXPECT_EQ(moments[0][1], moments[1][1]) << "15 microseconds earlier";
  EXPECT_NE(moments[0][2], moments[1][2]);
  EXPECT_EQ(std::set<std::string>(moments[0].begin(), moments[0].end()).size(), 3u);
  // Seconds with a fraction are one number, for the camera's name as for the moment.
  EXPECT_EQ(cameras::camera_name("left_1403636579.763555.png", "by_name"), "left");
  EXPECT_EQ(cameras::moment_of("left/1403636579.763555.png", "by_folder"), "1403636579.763555");
  EXPECT_EQ(cameras::camera_name("cam1.0050.png", "by_name"), "cam1");
  const auto seconds = cameras::moments_of(
      {{"l/1403636579.50.png", "l/1403636580.50.png"}, {"r/1403636579.51.png", "r/1403636580.49.png"}}, "by_folder");
  EXPECT_EQ(seconds[0], seconds[1]);
  EXPECT_NE(seconds[0][0], seconds[0][1]);
  // Numbers that count are taken by the letter.
  const auto counted = cameras::moments_of({{"l/10.png", "l/20.png"}, {"r/11.png", "r/21.png"}}, "by_folder");
  EXPECT_NE(counted[0][0], counted[1][0]);
}

TEST(LayoutFiles, KnowTheUnitsOfTheirColumnsOrRefuseThem) {
  for (const auto& [unit, metres] :
       {std::pair("m", 1.0), {"cm", 0.01}, {"mm", 0.001}, {"in", 0.0254}, {"ft", 0.3048}}) {
    const std::string u = unit;
    for (const std::string& head : {"tag_id,x_" + u + ",y_" + u + ",z_" + u + ",facing_azimuth_deg\n",
                                    "tag_id,x [" + u + "],y [" + u + "],z [" + u + "],facing_azimuth_deg\n"})
      EXPECT_NEAR(markers::parse_layout(head + "4,100,200,300,90\n", "l.csv")[0].world_from_tag.translation.y(),
                  200 * metres, 1e-9)
          << head;
  }
  EXPECT_THAT(message_of([] {
                markers::parse_layout("tag_id,x [yd],y [yd],z [yd],facing_azimuth_deg\n4,1,2,3,90\n", "l.csv");
              }),
              HasSubstr("column 'x' is in 'yd', expected m, mm, cm, in or ft"));
  EXPECT_THAT(
      message_of([] { markers::parse_layout("tag_id,x_deg,y_m,z_m,facing_azimuth_deg\n4,1,2,3,90\n", "l.csv"); }),
      HasSubstr("column 'x' is in 'deg'"));
  EXPECT_THAT(message_of([] { markers::parse_layout("tag_id,x,y,z,facing_azimuth_deg\n4.5,1,2,3,90\n", "l.csv"); }),
              HasSubstr("line 2: the id of a tag is a whole number"));
}

TEST(LayoutFiles, TurnWPILibsFacesIntoTags) {
  const auto tags = markers::parse_layout(
      R"({"tags":[{"ID":3,"pose":{"translation":{"x":1,"y":2,"z":3},"rotation":{"quaternion":{"W":1,"X":0,"Y":0,"Z":0}}}}]})",
      "field.json");
  ASSERT_EQ(tags.size(), 1u);
  const Eigen::Matrix3d r = tags[0].world_from_tag.rotation.toRotationMatrix();
  EXPECT_LT((r.col(2) - Eigen::Vector3d::UnitX()).norm(), 1e-12) << "out of the face";
  EXPECT_LT((r.col(1) - Eigen::Vector3d::UnitZ()).norm(), 1e-12) << "up";
  const auto csv =
      markers::parse_layout("tag_id,x_mm,y_mm,z_mm,facing_azimuth_deg\n7,1000,2000,500,180\n", "plates.csv");
  EXPECT_DOUBLE_EQ(csv[0].world_from_tag.translation.y(), 2);
  EXPECT_LT((csv[0].world_from_tag.rotation * Eigen::Vector3d::UnitZ() + Eigen::Vector3d::UnitY()).norm(), 1e-12);
  EXPECT_THAT(message_of([] {
                markers::parse_layout("tag_id,x_m,y_m,z_m,facing_azimuth_deg\n7,1,2,0,0\n7,3,2,0,0\n", "p.csv");
              }),
              HasSubstr("tag 7 stands in it twice"));
  EXPECT_THAT(message_of([] { markers::parse_layout("tag_id,x_m,y_m\n7,1,2\n", "p.csv"); }), HasSubstr("p.csv"));
}

TEST(RobustSimilarity, LeavesOutWhatDisagreesAndRefusesALine) {
  std::vector<Eigen::Vector3d> from, to;
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(1.1, Eigen::Vector3d(1, -2, 3).normalized()));
  for (int k = 0; k < 30; ++k) {  // more triples than are tried
    from.emplace_back(k % 5, k / 5, 0.3 * (k % 3));
    to.push_back(2.5 * (turn * from.back()) + Eigen::Vector3d(4e5, 5e6, 100));
  }
  to[3].x() += 2, to[17].z() -= 5;
  const auto fit = markers::fit_similarity_robustly(from, to, 0.05);
  EXPECT_NEAR(fit.motion.scale, 2.5, 1e-9);
  EXPECT_NEAR(fit.distances[3], 2, 1e-6);
  for (size_t k = 0; k < 30; ++k) EXPECT_EQ(fit.agrees[k], k != 3 && k != 17) << k;
  const std::vector<Eigen::Vector3d> line = {{0, 0, 0}, {1, 1, 1}, {2, 2, 2}, {5, 5, 5}};
  EXPECT_THAT(message_of([&] { markers::fit_similarity_robustly(line, line, 0.05); }), HasSubstr("on one line"));
}

TEST(SurveyFrame, CarriesPlateOffsetsThroughAnUnknownScale) {
  // Tags of unknown size: the network is 4 times too small. Points are 60 mm beside their tags.
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(-0.4, Eigen::Vector3d(2, 1, 1).normalized()));
  const Eigen::Vector3d shift(100, 200, 30), offset(0.06, 0, 0.01);
  markers::MarkerResult network;
  std::vector<markers::SurveyedTag> surveyed;
  for (int k = 0; k < 5; ++k) {
    markers::AdjustedMarker marker;
    marker.marker = k;
    marker.world_from_tag = {Eigen::Quaterniond(Eigen::AngleAxisd(0.5 * k, Eigen::Vector3d::UnitZ())),
                             Eigen::Vector3d(k % 2, k / 2, 0.2 * (k % 3))};
    network.markers.push_back(marker);
    const Eigen::Vector3d tag = 4 * (turn * marker.world_from_tag.translation) + shift;
    surveyed.push_back({k, "P" + std::to_string(k), tag - turn * (marker.world_from_tag.rotation * offset), offset});
  }
  const auto frame = markers::fit_to_survey(network, surveyed);
  EXPECT_NEAR(frame.motion.scale, 4, 2e-3);
  for (const double d : frame.distance) EXPECT_LT(d, 1e-3);
  const Eigen::Vector3d centre(0.3, 0.4, 5);
  const RigidTransform image{Eigen::Quaterniond::Identity(), -centre};
  EXPECT_LT((markers::in_survey_frame(frame, image).inverse().translation - (frame.motion * centre)).norm(), 1e-9);
  network.markers.resize(2);
  EXPECT_THAT(message_of([&] { markers::fit_to_survey(network, surveyed); }), HasSubstr("at least 3 are needed"));
}

/// Neighbours 42 mm apart were within what a start may be off by, and the block "did not converge".
TEST(SurveyFrame, NeighboursThatAreExchangedDoNotAgree) {
  markers::MarkerResult network;
  std::vector<markers::SurveyedTag> surveyed;
  for (int k = 0; k < 12; ++k) {
    markers::AdjustedMarker marker;
    marker.marker = k;
    marker.world_from_tag.translation = {0.042 * (k % 4), 0.042 * (k / 4), 0.001 * (k % 3)};
    network.markers.push_back(marker);
    surveyed.push_back({k, "P" + std::to_string(k), marker.world_from_tag.translation, Eigen::Vector3d::Zero()});
  }
  std::swap(surveyed[5].position, surveyed[6].position);
  surveyed[6].check = true;  // a check point has no part in the motion, but its place is known
  const auto frame = markers::fit_to_survey(network, surveyed);
  for (size_t k = 0; k < 12; ++k) {
    EXPECT_EQ(frame.agrees[k], k != 5 && k != 6) << k;
    EXPECT_NEAR(frame.distance[k], k == 5 || k == 6 ? 0.042 : 0, 2e-3) << k;
  }
  EXPECT_LT((frame.found[5] - surveyed[6].position).norm(), 1e-3);
}

TEST(ColmapFiles, ComeBackAsTheyWereWritten) {
  cameras::ColmapModel model;
  cameras::ColmapCamera camera;
  camera.id = 1, camera.camera = {640, 480, 600, 610, 319.5, 239.5, -0.1, 0.02, 0, 0.001, 0.002};
  model.cameras[1] = camera;
  cameras::ColmapImage image;
  image.id = 4, image.camera = 1, image.name = "a b.jpg";
  image.cam_from_world = {Eigen::Quaterniond(0.8, 0.6, 0, 0), {1, 2, 3}};
  image.features = {{{10.25, 20.5}, 9}, {{30, 40}, -1}};
  model.images[4] = image;
  cameras::ColmapPoint point;
  point.position = {1, 2, 3}, point.error = 0.5, point.track = {{4, 0}};
  model.points[9] = point;
  const test::TemporaryFolder folder;
  for (const auto& [name, text] : cameras::colmap_text(model)) std::ofstream(folder.path() / name) << text;
  const auto back = cameras::read_colmap(folder.path().string());
  EXPECT_EQ(back.cameras.at(1).camera.parameters(), camera.camera.parameters());
  EXPECT_EQ(back.images.at(4).name, "a b.jpg");
  EXPECT_EQ(back.images.at(4).features.at(0).pixel, image.features[0].pixel);
  EXPECT_EQ(back.points.at(9).track, point.track);
  for (const auto& [line, parameters] : {std::pair("1 OPENCV_FISHEYE 640 480 300 301 320 240 5 6 7 8\n",
                                                   std::array<double, 9>{300, 301, 319.5, 239.5, 5, 6, 7, 8, 0}),
                                         std::pair("1 RADIAL_FISHEYE 640 480 300 320 240 5 6\n",
                                                   std::array<double, 9>{300, 300, 319.5, 239.5, 5, 6, 0, 0, 0}),
                                         std::pair("1 SIMPLE_RADIAL_FISHEYE 640 480 300 320 240 5\n",
                                                   std::array<double, 9>{300, 300, 319.5, 239.5, 5, 0, 0, 0, 0})}) {
    std::ofstream(folder.path() / "cameras.txt") << line;
    const auto fisheye = cameras::read_colmap(folder.path().string());
    EXPECT_EQ(fisheye.cameras.at(1).camera.lens, LensModel::fisheye);
    EXPECT_EQ(fisheye.cameras.at(1).camera.parameters(), parameters);
    EXPECT_THAT(cameras::colmap_text(fisheye).at("cameras.txt"), HasSubstr("1 OPENCV_FISHEYE 640 480 300 30"));
  }
  std::ofstream(folder.path() / "points3D.txt") << "9 1 2 3 0 0 0 0.5 7 0\n";
  EXPECT_THAT(message_of([&] { cameras::read_colmap(folder.path().string()); }),
              HasSubstr("image 7, which is not there"));
  std::ofstream(folder.path() / "cameras.txt") << "1 FOV 640 480 1 2 3 4 5\n";
  EXPECT_THAT(message_of([&] { cameras::read_colmap(folder.path().string()); }), HasSubstr("is FOV; known are"));
  EXPECT_THAT(message_of([] { cameras::read_colmap("/nowhere"); }), HasSubstr("no COLMAP model"));
}

}  // namespace test_files
}  // namespace plumbline
