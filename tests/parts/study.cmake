if(TARGET mv_study AND TARGET mvprep)
  mv_add_test(unit_study SOURCES unit/study/case_maker_test.cpp LIBRARIES mv_study)
  add_dependencies(unit_study mvprep)
endif()
