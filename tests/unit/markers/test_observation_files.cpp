// read.image_observations: our own JSON and CSV back in.
#include <gmock/gmock.h>

#include <cmath>
#include <fstream>

#include "artifacts/tag_observations.hpp"
#include "node_harness.hpp"

namespace plumbline::test {
namespace test_observation_files {

using testing::AllOf;
using testing::HasSubstr;

TagObservationsT read_back(const std::string& text, std::string& refusal) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "tags";
  std::ofstream(file, std::ios::binary) << text;
  NodeHarness node("read.image_observations");
  node.set("file", file.string());
  try {
    node.run();
    return node.output<TagObservations>("observations");
  } catch (const NodeFailed& error) {
    refusal = error.what();
    return {};
  }
}

TagObservationsT taken(const std::string& text) {
  std::string refusal;
  TagObservationsT found = read_back(text, refusal);
  EXPECT_EQ(refusal, "");
  return found;
}

std::string refused(const std::string& text) {
  std::string refusal;
  read_back(text, refusal);
  return refusal;
}

const std::string kHead = "image,family,tag_id,x0_px,y0_px,x1_px,y1_px,x2_px,y2_px,x3_px,y3_px,sigma_px\n";
const std::string kRow = "a.jpg,tag36h11,7,10,50,50,51,52,11,12,10,0.2\n";

TEST(ObservationFiles, ACampaignsTableIsRead) {
  for (const std::string& text :
       {kHead + kRow + "b.jpg,tag36h11,8,1,2,3,4,5,6,7,8,0.1\na.jpg,tag36h11,3,1,2,3,4,5,6,7,8,0.1\n",
        "\xef\xbb\xbf" + kHead + kRow + "b.jpg,tag36h11,8,1,2,3,4,5,6,7,8,0.1\r\n" +
            "a.jpg,tag36h11,3,1,2,3,4,5,6,7,8,0.1\r\n"}) {
    const TagObservationsT found = taken(text);
    ASSERT_EQ(found.images.size(), 2u);
    EXPECT_EQ(found.images[0]->path, "a.jpg");
    ASSERT_EQ(found.images[0]->tags.size(), 2u);
    const TagT& tag = *found.images[0]->tags[0];
    EXPECT_EQ(tag.family, "tag36h11");
    EXPECT_EQ(tag.id, 7);
    EXPECT_EQ(tag.corners[0], Eigen::Vector2d(10, 50));
    EXPECT_EQ(tag.corners[3], Eigen::Vector2d(12, 10));
    EXPECT_THAT(tag.corner_covariances, testing::SizeIs(12));
    EXPECT_DOUBLE_EQ(tag.corner_covariances[9], 0.04);
    EXPECT_DOUBLE_EQ(tag.corner_covariances[10], 0);
    EXPECT_TRUE(tag.refined);
  }
}

TEST(ObservationFiles, WrongTablesAreRefusedWithTheirLine) {
  EXPECT_THAT(refused(kHead + kRow + kRow), HasSubstr("tags:3: tag 7 stands here a second time in image 'a.jpg'"));
  EXPECT_THAT(refused(kHead + "a.jpg,tag36h11,7,10,50,50,51,52,11,12,10,0\n"), HasSubstr("tags:2: sigma: found 0"));
  EXPECT_THAT(refused(kHead + "a.jpg,tag36h11,7,ten,50,50,51,52,11,12,10,1\n"), HasSubstr("tags:2: x0: found 'ten'"));
  EXPECT_THAT(refused(kHead + "a.jpg,tag36h11,7.5,10,50,50,51,52,11,12,10,1\n"), HasSubstr("no whole number"));
  EXPECT_THAT(refused(kHead + "a.jpg,tag36h11,7,10,50,50\n"), HasSubstr("tags:2: the cell of column 'y1' is missing"));
  EXPECT_THAT(refused("image,family,id\na.jpg,tag36h11,3\n"), HasSubstr("no column 'tag_id'"));
  EXPECT_THAT(refused(kHead), HasSubstr("holds no tag"));
  EXPECT_THAT(refused(""), testing::Not(""));
}

std::string json_of(const std::string& id, const std::string& covariances, const std::string& more = "") {
  return R"({"images":[{"path":"a.jpg","tags":[{"family":"tag36h11","id":)" + id +
         R"(,"corners":[[1,2],[3,4],[5,6],[7,8]],"covariance":)" + covariances + "}]}" + more + "]}";
}

TEST(ObservationFiles, WhatIsNoCovarianceNoIdOrASecondImageIsRefusedInJson) {
  const std::string sound = "[[1,0,1],[1,0,1],[1,0.5,1],[1,0,1]]";
  EXPECT_EQ(taken(json_of("5", sound)).images.size(), 1u);
  EXPECT_THAT(refused(json_of("5", "[[1,0,1],[1,0,1],[1,2,1],[1,0,1]]")),
              AllOf(HasSubstr("image 'a.jpg', tag 1"), HasSubstr("[1,2,1], which is no covariance")));
  EXPECT_THAT(refused(json_of("5", "[[1,0,1],[1,0,1],[1,0,-1],[1,0,1]]")), HasSubstr("no covariance"));
  EXPECT_THAT(refused(json_of("5", "[[1,0,1],[1,0,1]]")), HasSubstr("found 2 covariances"));
  EXPECT_THAT(refused(json_of("5", "[[1,0],[1,0,1],[1,0,1],[1,0,1]]")), HasSubstr("three numbers"));
  EXPECT_THAT(refused(json_of("1e20", sound)), HasSubstr("the id is no whole number"));
  EXPECT_THAT(refused(json_of("5", sound, R"(,{"path":"a.jpg","tags":[]})")),
              HasSubstr("image 'a.jpg': stands here a second time"));
}

TEST(ObservationFiles, TheInsetThatADetectorStatesIsReadBack) {
  const auto with = [](const std::string& inset) {
    return R"({"images":[{"path":"a.jpg",)" + inset +
           R"("tags":[{"family":"tag36h11","id":5,"corners":[[1,2],[3,4],[5,6],[7,8]]}]}]})";
  };
  EXPECT_EQ(taken(with(R"("corner_inset_sigma":0.125,)")).images[0]->corner_inset_sigma, 0.125);
  EXPECT_TRUE(std::isnan(taken(with("")).images[0]->corner_inset_sigma)) << "files of before state none";
  EXPECT_THAT(refused(with(R"("corner_inset_sigma":-0.1,)")),
              AllOf(HasSubstr("image 'a.jpg'"), HasSubstr("corner_inset_sigma is -0.1, expected are 0 to 10 px")));
}

}  // namespace test_observation_files
}  // namespace plumbline::test
