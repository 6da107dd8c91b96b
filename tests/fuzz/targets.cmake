# Every fuzz target, listed once for the build (fuzz/CMakeLists.txt) and for the suite (../CMakeLists.txt):
#
#   nlg_fuzz_target(NAME RUNS in the suite OPTIONS of libFuzzer … SOURCES beside NAME_fuzz.cpp … LINKS …)
#
# The one that the suite builds and runs every day: light grids are what engines read, and little to build. The others are heavy.
set(NLG_FUZZED_DAILY light_grid)
nlg_fuzz_target(weights RUNS 8000 OPTIONS -max_len=4096 SOURCES weights_seeds.cpp digests.cpp LINKS fuzzed_generator)
nlg_fuzz_target(light_grid RUNS 20000 OPTIONS -max_len=12000 SOURCES light_grid_seeds.cpp digests.cpp LINKS fuzzed_light_grid)
nlg_fuzz_target(gltf RUNS 20000 OPTIONS -max_len=4096 -dict=gltf.dict LINKS fuzzed_scene GTest::gtest)
nlg_fuzz_target(obj RUNS 20000 OPTIONS -max_len=4096 LINKS fuzzed_scene)
nlg_fuzz_target(bsp RUNS 20000 OPTIONS -max_len=8192 LINKS fuzzed_scene)
nlg_fuzz_target(pk3 RUNS 10000 OPTIONS -max_len=8192 SOURCES zip_file.cpp LINKS fuzzed_scene nlg::deflate)
nlg_fuzz_target(shader_script RUNS 60000 OPTIONS -max_len=2048 -dict=quake.dict LINKS fuzzed_scene)
nlg_fuzz_target(entities RUNS 60000 OPTIONS -max_len=2048 -dict=quake.dict LINKS fuzzed_scene)
nlg_fuzz_target(texture RUNS 60000 OPTIONS -max_len=1024 LINKS fuzzed_scene)
nlg_fuzz_target(sky RUNS 20000 OPTIONS -max_len=4096 LINKS fuzzed_scene)
nlg_fuzz_target(options RUNS 20000 OPTIONS -max_len=1024 LINKS fuzzed_options)
nlg_fuzz_target(shard RUNS 400 OPTIONS -max_len=512 -detect_leaks=0 SOURCES hdf5_recipe.cpp LINKS fuzzed_dataset)
nlg_fuzz_target(basis RUNS 250 OPTIONS -max_len=512 -detect_leaks=0 SOURCES hdf5_recipe.cpp LINKS fuzzed_dataset)
nlg_fuzz_target(cache RUNS 20000 OPTIONS -max_len=1024 LINKS fuzzed_dataset)
nlg_fuzz_target(checkpoint RUNS 20000 OPTIONS -max_len=4096 SOURCES digests.cpp LINKS fuzzed_dataset)
