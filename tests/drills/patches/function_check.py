"""Questions use the function, in conditions and as a whole."""

from pathlib import Path

import mcml
from tests.builders import bvh

Path("walk.bvh").write_bytes(bvh(30))
with mcml.open("store.db") as store:
    store.import_("walk.bvh")
    below = store.xpath("count(//@Rx[. < 0])").value()
    assert 0 < store.xpath("count(//@Rx[signum(.) = -1])").value() == below
    assert store.xpath("signum(count(//frame))").value() == 1
