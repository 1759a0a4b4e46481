//! Files with surfaces of obstacles that are given to a page.

use super::state::ServerState;
use axum::body::{Body, to_bytes};
use axum::extract::{Path, State};
use axum::http::{HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use std::sync::Arc;
use tokio::sync::Semaphore;
use wireloom::session::Refusal;

/// Largest file, bytes: a mesh of five million triangles. A larger one is put beside the scenario by hand.
pub const MAX_MESH_FILE: usize = 256 << 20;
/// One file at a time is in memory.
static ALONE: Semaphore = Semaphore::const_new(1);

/// `POST /surroundings/NAME`: the file with that name. The answer is a [`crate::protocol::StoredMesh`] as JSON; of a
/// file that is refused, a line why, and one with what would be right.
pub async fn store(State(state): State<Arc<ServerState>>, Path(name): Path<String>, body: Body) -> Response {
    let Ok(_alone) = ALONE.acquire().await else { return StatusCode::INTERNAL_SERVER_ERROR.into_response() };
    let Ok(bytes) = to_bytes(body, MAX_MESH_FILE).await else {
        let words = format!("the file did not come whole, or has more than {MAX_MESH_FILE} bytes\n");
        return (StatusCode::PAYLOAD_TOO_LARGE, words).into_response();
    };
    let stored = tokio::task::spawn_blocking(move || {
        let live = state.live().ok_or_else(|| Refusal::new("there is no session", "open a scenario first"))?;
        live.store_mesh(&name, bytes.into())
    });
    match stored.await {
        Ok(Ok(mesh)) => {
            let kind = (header::CONTENT_TYPE, HeaderValue::from_static("application/json"));
            ([kind], serde_json::to_string(&mesh).unwrap_or_default()).into_response()
        }
        Ok(Err(Refusal { message, help })) => {
            (StatusCode::UNPROCESSABLE_ENTITY, format!("{message}\n{help}\n")).into_response()
        }
        Err(_) => (StatusCode::INTERNAL_SERVER_ERROR, "the file could not be read\n").into_response(),
    }
}
