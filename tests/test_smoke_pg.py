def test_x(database):
    assert database.schema_versions()[0]=="0001"
