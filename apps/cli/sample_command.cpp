#include "cli.h"

#include "skinfield/sample/sample.h"

namespace skinfield::cli {

void add_sample(CLI::App& app, Common& common, std::vector<std::pair<CLI::App*, Verb>>& verbs) {
  struct Options {
    std::string name, output;
    SampleOptions sample;
  };
  auto o = std::make_shared<Options>();
  CLI::App* verb = new_verb(app, common, "sample", "Write a sample character, made by code",
                            "skinfield sample gecko -o gecko.glb");
  std::vector<std::string> names;
  for (std::string_view name : sample_names()) names.emplace_back(name);
  verb->add_option("name", o->name, "gecko: clean and closed; robot: overlapping parts; scan: torn")
      ->required()
      ->check(CLI::IsMember(names));
  verb->add_option("-o,--output", o->output, "The .glb to write")->required();
  verb->add_option("--triangles", o->sample.resolution, "About so many triangles [16000]")
      ->check(number(500, 2000000));
  verb->add_option("--seed", o->sample.seed, "Which faces the scan lost")
      ->check(number(0, 1e18))
      ->capture_default_str();
  verbs.emplace_back(verb, [o, &common] {
    if (std::string_view(o->output).ends_with(".glb") == false)
      throw UsageError(o->output + ": a sample is written as .glb");
    check_outputs({o->output});
    o->sample.progress = make_progress(common);
    write_sample(o->output, make_sample(o->name, o->sample));
  });
}

}  // namespace skinfield::cli
