// What every section of the panel needs.

import type { Actions } from "../actions";
import type { Store } from "../store";

export interface Panel {
    store: Store;
    actions: Actions;
}
