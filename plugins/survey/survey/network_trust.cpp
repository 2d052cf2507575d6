#include "network_trust.hpp"

#include <flatbuffers/flatbuffers.h>

#include <utility>

#include "building/judgement/trust.hpp"

namespace plumbline::survey {

bool proves_nothing(SurveyNetworkT& network) {
  // The law asks for none of the readings, which are nearly all of a large network.
  auto observations = std::exchange(network.observations, {});
  flatbuffers::FlatBufferBuilder builder;
  builder.Finish(SurveyNetwork::Pack(builder, &network));
  network.observations = std::move(observations);
  const auto* packed = flatbuffers::GetRoot<SurveyNetwork>(builder.GetBufferPointer());
  return !judgement::trust_of(nullptr, packed).doubts.empty();
}

}  // namespace plumbline::survey
